"""Pressing plastic material down to a given thickness."""

from __future__ import annotations

from collections.abc import Callable

from stretch_bt import perception
from stretch_bt.behaviors._force import ForceMean
from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.behaviors._motion import MOST_DEPTH, MotionBehavior, lowest_of, touched_at
from stretch_bt.behaviors._top_height import height_over_table
from stretch_bt.behaviors.records import Mounting, Touch
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.ages import PLACE
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, Motion, MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.model.control.thickness import next_step
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.context import Context
from stretch_bt.tree.ports import In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Estimate, Force, Length, Speed

SHARE = 0.97  # largest force asked for, over the force at which the cell stops the arm
FRAMES = 2  # frames averaged at each look
FORCES = 10  # readings of the force averaged at the end


@node
class PressToThickness(MotionBehavior):
    """Press plastic material down to a given thickness over the table, as the camera sees it, or until the force reaches its limit.

    The hand goes down by the way that the top still has to fall and looks again, so that it comes to the thickness from above.
    SUCCESS however it ended. FAILURE when the camera sees nothing in the membrane, no membrane, or a top out of its reach.
    """

    arm: Uses[Arm]
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper | None]
    force_sensor: Uses[ForceSensor | None]
    touch: In[Touch]  # first contact, from which depths count
    pattern: In[Pattern | None] = None  # static error of the camera, which is taken off
    mounting: In[Mounting | None] = None  # mounting of the membrane, as far as it is known
    thickness: In[Length] = port(min=0.001, max=0.1, doc="wanted thickness under the press")
    speed: In[Speed] = port(0.005, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")
    max_force: In[Force] = port(18.0, min=0.05, max=50.0, doc="force at which to stop", limit="lowered_force")
    max_depth: In[Length] = port(MOST_DEPTH, min=0.0, max=MOST_DEPTH, doc="past first contact; the cell may bound it")
    reached: Out[Length]  # thickness under the press
    force: Out[Force]  # mean of ten readings of the arm's force along the hand's axis, at the end
    ended: Out[str]  # cause of the end: `thickness`, `force`, or `depth` where the hand may not go deeper

    def initialise(self) -> None:
        """Look first."""
        super().initialise()
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        self.most = _most(self.max_force, self.limit.margin, self.context.limits)
        self.looks, self.limited = 0, False
        self._look()

    def start(self) -> Motion:
        """Go down to where the top would be low enough if it fell as far as the hand."""
        self.motion = self.arm.move(self.target, speed=self.speed, owner=self.path)
        return self.motion

    def update(self) -> Status:
        """Go on with looking, or with moving."""
        return self.phase()

    def _look(self) -> None:
        self.look = _Look(self)
        self.phase: Callable[[], Status] = self._see

    def _see(self) -> Status:
        top = self.look.top()
        if top is None:
            return Status.RUNNING
        self.looks += 1
        lowest = _lowest(touched_at(self.context, self.touch), self.max_depth, self.context)
        pose = self.arm.pose(PLACE).value
        step = next_step(top.value, self.thickness, pose.height, lowest, limited=self.limited, steps=self.looks)
        if step.ended:
            self.found, self.readings = (top, step.ended), ForceMean(self.context, self.arm, self.arm)
            self.phase = self._feel
        else:
            self.target, self.phase = pose.at_height(step.height), self._move
            self.start()
        return Status.RUNNING

    def _feel(self) -> Status:
        if self.readings.add() < FORCES:
            return Status.RUNNING
        self.force = self.readings.estimate(self.arm.force_noise())
        self.reached, self.ended = self.found
        return Status.SUCCESS

    def _move(self) -> Status:
        assert self.motion is not None
        state = self.motion.poll()
        if state not in (MotionState.MOVING, MotionState.DONE):
            return super().update()
        self.limited = self.limit.reached(self.most)
        if state is MotionState.MOVING:
            if not self.limited:
                return Status.RUNNING
            self.motion.stop()
        self.motion = None
        self._look()
        return Status.RUNNING


class _Look:
    """Takes frames while the hand stands still, and finds the top in their mean."""

    def __init__(self, node: PressToThickness) -> None:
        self._node = node
        self._source = FrameSource(node.context, node.camera, node.arm, node.gripper)
        self._frames: list[DepthFrame] = []

    def top(self) -> Estimate | None:
        """Take the next frame, if any, and return the top's height over the table, m, once there are enough frames."""
        frame = self._source.next()
        self._frames += [] if frame is None else [frame]
        if len(self._frames) < FRAMES:
            return None
        node = self._node
        shot = corrected(perception.average_frames(self._frames), node.pattern, node.device_names["camera"])
        return height_over_table(shot, node.context.hand.geometry, node.mounting, node.pattern)


def _most(force: Force, margin: float, limits: Limits | None) -> float:
    """Return the force to stop at, N: the cell stops the arm a little above it at the earliest."""
    return force if limits is None else min(force, SHARE * limits.force - margin)


def _lowest(touched: Length, depth: Length, context: Context) -> float:
    """Return the world height, m, that is a depth past first contact, or as deep as the cell allows."""
    limits = context.limits
    return max(touched - (depth if limits is None else min(depth, limits.depth)), lowest_of(context))
