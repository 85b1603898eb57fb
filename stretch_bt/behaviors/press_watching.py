"""Pressing as far as an object bears."""

from __future__ import annotations

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.behaviors._motion import MOST_DEPTH, MotionBehavior, lowest_of, touched_at
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, Motion
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.top_watch import TopWatch
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed

SAFE = 0.8  # share of the force at which the cell stops the arm
LEAST = 0.0005  # m, least depth of a press past first contact


@node
class PressWatching(MotionBehavior):
    """Lower the hand to a depth, and stop earlier where the force reaches a limit or the object's top gives way.

    Depths count from the height of first contact. The force stays below four fifths of the force at which the cell stops the arm.
    With a map of earlier presses the top is watched while the hand sinks. The hand also stops where the membrane has no equilibrium because
    it slips off an object under its free side: `rise_to_balance` then. SUCCESS however it ended, with the cause;
    FAILURE when the limit is reached before the hand is below first contact.
    """

    arm: Uses[Arm]
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper | None]
    force_sensor: Uses[ForceSensor | None]
    touch: In[Touch]  # first contact, from which depths count
    depth: In[Length] = port(min=0.0, max=MOST_DEPTH, doc="largest depth past first contact", limit="depth")
    speed: In[Speed] = port(0.010, min=0.0005, max=0.050, doc="speed of the hand", limit="contact_speed")
    max_force: In[Force] = port(5.0, min=0.05, max=50.0, doc="force at which to stop", limit="lowered_force")
    max_deflection: In[Length] = port(0.001, min=0.0001, max=0.02, doc="fall of the top at which to stop")
    relief: In[Relief | None] = None  # map of earlier presses
    pattern: In[Pattern | None] = None  # static error of the camera, which is taken off
    ended: Out[str]  # cause of the end: `depth`, `force`, `deflection` or `balance`, which the membrane lost

    def initialise(self) -> None:
        """Take frames from now on."""
        super().initialise()
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.limit = ForceLimit(self._most(), self.arm, self.force_sensor, self.context)
        place = None if self.relief is None else self.relief.summit
        self.top = None if place is None else TopWatch(place)

    def start(self) -> Motion:
        """Move straight down."""
        pose, contact = self.arm.pose(PRESSING_PLACE).value, touched_at(self.context, self.touch)
        target = max(contact - self.depth, lowest_of(self.context))
        return self.arm.move(pose.at_height(target), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Go on; the arm's own look at its force may be the first to find that the membrane has no equilibrium."""
        try:
            return super().update()
        except NoEquilibrium:
            return self._end("balance")

    def watch(self) -> Status | None:
        """Stop at the limit of force, or when the top gives way."""
        if self.limit.reached():
            return self._end("force")
        if self.top is None or not self.top.is_due(depth := self._depth()):
            return None
        frame = self.source.next()
        if frame is None:
            return None
        shot = corrected(frame, self.pattern, self.device_names["camera"])
        return self._end("deflection") if self.top.fell(shot, depth, self.max_deflection) else None

    def arrived(self) -> Status:
        """Look at the force once more."""
        return self._end("force" if self.limit.reached() else "depth")

    def _depth(self) -> float:
        return self.touch.height - self.arm.pose(PRESSING_PLACE).value.height

    def _most(self) -> float:
        limits = self.context.limits
        return self.max_force if limits is None else min(self.max_force, SAFE * limits.force)

    def _end(self, ended: str) -> Status:
        depth = self._depth()
        if depth < LEAST and ended != "balance":
            self.reason = f"the limit of {ended} was reached {-depth * 1e3:.1f} mm above first contact: something else is in the way"
            return Status.FAILURE
        self.ended = ended
        return Status.SUCCESS
