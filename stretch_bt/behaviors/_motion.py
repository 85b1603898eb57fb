"""The common part of nodes that move a device: one motion at a time, stopped only by its owner."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stretch_bt.errors import NodeError, shown
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import Motion, MotionState
from stretch_bt.tree.context import Context
from stretch_bt.tree.own_calls import calls_own
from stretch_bt.tree.ports import Behavior, Status

if TYPE_CHECKING:
    from stretch_bt.behaviors.records import Touch

__all__ = ["MOST_DEPTH", "MOST_STRETCH", "MotionBehavior", "lowest_of", "slowed", "touched_at"]

#: largest stretch past the rest length and largest depth past first contact that a node may ask of the hand, m
MOST_STRETCH, MOST_DEPTH = 0.080, 0.030

_ENDED = {
    MotionState.BLOCKED: "the motion was blocked before its target",
    MotionState.STOPPED: "the motion was stopped",
    MotionState.PREEMPTED: "another node took the device over",
}


def slowed(context: Context, speed: float, way: Sequence[Pose]) -> float:
    """Return a speed, m/s, or the lower one that the cell allows where the hand may meet something on its way."""
    limits = context.limits
    return speed if limits is None else limits.slowed(speed, [pose.height for pose in way])


def lowest_of(context: Context) -> float:
    """Return the world height, m, down to which the cell lets the hand go; the table's where no cell limits it."""
    return 0.0 if context.limits is None else context.limits.height.min


def touched_at(context: Context, touch: Touch) -> float:
    """Return the world height of first contact, m, from which the limits of the cell count depths, too, from now on."""
    context.hand.contact_height = touch.height
    return touch.height


class MotionBehavior(Behavior):
    """Starts a motion and runs until it ends; interrupted, it stops the motion unless another node owns the device."""

    kind = "actuation"

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.motion: Motion | None = None

    @abstractmethod
    def start(self) -> Motion:
        """Give the command and return its motion."""

    def watch(self) -> Status | None:
        """Look at the world while moving; return a status to end with, or None to go on."""
        return None

    def arrived(self) -> Status:
        """Return the status to end with when the motion reached its target."""
        return Status.SUCCESS

    def initialise(self) -> None:
        """Forget the motion of an earlier start."""
        self.motion = None

    @calls_own
    def update(self) -> Status:
        """Start, then poll."""
        if self.motion is None:
            self.motion = self._started()
        state = self.motion.poll()
        if state is MotionState.MOVING:
            return self.watch() or Status.RUNNING
        if state is MotionState.DONE:
            return self.arrived()
        self.reason = _ENDED[state]
        return Status.FAILURE

    @calls_own
    def _started(self) -> Motion:
        """Start, and refuse a result that is no motion: it could be neither followed nor stopped."""
        motion = self.start()
        if not callable(getattr(motion, "poll", None)) or not callable(getattr(motion, "stop", None)):
            hint = "return the motion that the device gives, as in 'return self.arm.move(...)'"
            raise NodeError(self.path, f"{type(self).__name__}.start() returned {shown(motion)}; {hint}")
        return motion

    def terminate(self, new_status: Status) -> None:
        """Stop the motion; does nothing when it has ended or belongs to another node."""
        if self.motion is not None:
            motion, self.motion = self.motion, None
            motion.stop()
