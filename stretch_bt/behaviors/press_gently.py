"""Pressing as far as an object bears."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._frames import FrameSource, corrected
from stretch_bt.behaviors._motion import MOST_DEPTH, MotionBehavior, touched_at
from stretch_bt.behaviors.records import Touch
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, Motion
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.views import surface_of
from stretch_bt.perception.deprojection import to_world
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.ports import In, Out, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed

MAX_AGE = 0.2
SAFE = 0.8  # of the force at which the cell stops the arm
LEAST = 0.0005  # m below the height of first contact: less is no press
LATEST = 3  # looks whose mean tells whether the top has fallen
APART = 0.8e-3  # m that the hand sinks between them at least: from one frame to the next little changes
AROUND = 0.003  # m round the highest place
BACK = 0.001  # m to rise by where nothing answers
CLEAR = 0.002  # m above first contact at which a hand that went back stays


@node
class PressGently(MotionBehavior):
    """Lower the hand to a depth, and stop before where the force reaches a limit or the object's top gives way.

    Depths count from the height of first contact. The force stays below four fifths of that at which the cell stops the arm.
    With a map of what was felt the top is watched while the hand sinks. Where the membrane has no equilibrium, as it slips off an object
    under its free side, the hand goes back up to where it has one. SUCCESS however it ended, with what ended it;
    FAILURE when the limit is reached before the hand is below first contact.
    """

    arm: Uses[Arm]
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper | None]
    force_sensor: Uses[ForceSensor | None]
    touch: In[Touch]  # first contact, from which depths count
    depth: In[Length] = port(min=0.0, max=MOST_DEPTH, doc="at most, past first contact", limit="depth")
    speed: In[Speed] = port(0.010, min=0.0005, max=0.050, doc="of the hand", limit="contact_speed")
    max_force: In[Force] = port(5.0, min=0.05, max=50.0, doc="stop here", limit="lowered_force")
    max_drop: In[Length] = port(0.001, min=0.0001, max=0.02, doc="stop when the top has fallen by this")
    relief: In[Relief | None] = None  # what was felt before
    pattern: In[Pattern | None] = None  # static error of the camera, which is taken off
    reached: Out[Length]  # depth at which the hand stands now, 0 above first contact
    ended: Out[str]  # by what: `depth`, `force`, `drop` or `balance`, which the membrane lost

    def initialise(self) -> None:
        """Take frames from now on."""
        super().initialise()
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.limit = ForceLimit(self._most(), self.arm, self.force_sensor, self.context)
        self.tops: list[float] = []
        self.looked = -math.inf  # depth of the latest look
        self.lost = False
        self.place = None if self.relief is None else self.relief.summit

    def start(self) -> Motion:
        """Move straight down."""
        pose, contact = self.arm.pose(MAX_AGE).value, touched_at(self.context, self.touch)
        return self.arm.move(pose.at_height(max(contact - self.depth, 0.0)), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Go on, or up where the membrane has no equilibrium, which the arm's own look at its force may tell first."""
        try:
            return super().update()
        except NoEquilibrium:
            if not self.lost:
                self._rise()
            return Status.RUNNING

    def watch(self) -> Status | None:
        """Stop at the limit of force, or when the top gives way."""
        return None if self.lost else self._limited()

    def _limited(self) -> Status | None:
        if self.limit.force() >= self.limit.limit:
            return self._end("force")
        if self.place is None or (depth := self._depth()) < self.looked + APART:
            return None
        frame = self.source.next()
        if frame is None:
            return None
        self.looked = depth
        return self._end("drop") if self._fell(corrected(frame, self.pattern, self.device_names["camera"])) else None

    def arrived(self) -> Status:
        """Tell how deep it is."""
        try:
            force = self.limit.force()
        except NoEquilibrium:
            if self.arm.pose(MAX_AGE).value.height < self.touch.height + CLEAR / 2:
                self._rise()
                return Status.RUNNING
            force = 0.0
        if self.lost:
            self.reached, self.ended = max(self._depth(), 0.0), "balance"
            return Status.SUCCESS
        return self._end("force" if force >= self.limit.limit else "depth")

    def _rise(self) -> None:
        """Go up a little, and from close to first contact clear of it."""
        if self.motion is not None:
            self.motion.stop()
        self.lost, pose = True, self.arm.pose(MAX_AGE).value
        high = self.touch.height + CLEAR
        target = pose.height + BACK if self._depth() > 2 * BACK else high
        self.motion = self.arm.move(pose.at_height(target), speed=self.speed, owner=self.path)

    def _depth(self) -> float:
        return self.touch.height - self.arm.pose(MAX_AGE).value.height

    def _most(self) -> float:
        limits = self.context.limits
        return self.max_force if limits is None else min(self.max_force, SAFE * limits.force)

    def _fell(self, frame: DepthFrame) -> bool:
        """Tell whether the highest place known stands lower than it was felt; one that is out of sight does not."""
        assert self.place is not None
        x, y, height = self.place
        points = surface_of(frame).reshape(-1, 3)
        if frame.pose is None:
            raise InvalidInput("the frame does not say where the hand is; declare an arm")
        world = to_world(points, frame.pose)
        near = world[np.hypot(world[:, 0] - x, world[:, 1] - y) < AROUND, 2]
        if len(near):
            self.tops = [*self.tops, float(near.mean())][-LATEST:]
        return len(self.tops) == LATEST and float(np.mean(self.tops)) < height - self.max_drop

    def _end(self, ended: str) -> Status:
        depth = self._depth()
        if depth < LEAST:
            self.reason = f"the limit of {ended} was reached {-depth * 1e3:.1f} mm above first contact: something else is in the way"
            return Status.FAILURE
        self.reached, self.ended = depth, ended
        return Status.SUCCESS
