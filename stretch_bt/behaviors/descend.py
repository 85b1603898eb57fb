"""Lowering the hand until it touches."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from typing import ClassVar

from stretch_bt.behaviors._force_limit import ForceLimit
from stretch_bt.behaviors._frames import FrameSource
from stretch_bt.behaviors._motion import MotionBehavior, lowest_of
from stretch_bt.behaviors.records import FreeMembrane
from stretch_bt.errors import NoContact
from stretch_bt.hardware.ages import PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, Motion
from stretch_bt.tree.ports import In, InOut, Status, Uses, port
from stretch_bt.tree.registry import node
from stretch_bt.units import Force, Length, Speed


@node
class Descend(MotionBehavior):
    """Lower the hand until the camera sees contact, and stop there; FAILURE when nothing was met.

    It goes down as far as the limits of the cell allow. Up to the touch every frame shows the free membrane, and is added to
    `free_membrane`.
    """

    arm: Uses[Arm]
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper | None]
    force_sensor: Uses[ForceSensor | None]
    speed: In[Speed] = port(0.010, min=0.001, max=0.050, doc="speed of the hand", limit="contact_speed")
    max_travel: In[Length | None] = port(
        None, min=0.001, max=2.0, doc="largest way down before it gives up, unless the cell ends before that"
    )
    max_force: In[Force] = port(5.0, min=0.05, max=50.0, doc="force above which to stop and fail", limit="held_force")
    free_membrane: InOut[FreeMembrane]  # frames of the free membrane, by `watch_free_membrane`

    #: frames in a row that must show contact
    ALARMS: ClassVar[int] = 2

    def initialise(self) -> None:
        """Take frames from now on."""
        super().initialise()
        self.context.hand.contact_height = None  # an earlier object's depth limit does not bound the way to the next
        self.limit = ForceLimit(self.max_force, self.arm, self.force_sensor, self.context)
        self.source = FrameSource(self.context, self.camera, self.arm, self.gripper)
        self.free = deepcopy(self.free_membrane)
        self.frames = self.alarms = 0

    def start(self) -> Motion:
        """Move down, as far as allowed."""
        pose = self.arm.pose(PRESSING_PLACE).value
        self.goal = min(max(pose.height - (self.max_travel or math.inf), lowest_of(self.context)), pose.height)
        return self.arm.move(pose.at_height(self.goal), speed=self.speed, owner=self.path)

    def update(self) -> Status:
        """Look, and go on."""
        self.reason = "moving down"
        frame = self.source.next()
        if frame is not None:
            self.alarms = self.alarms + 1 if self.free.detector.update(frame) else 0
            self.free.view.add(frame)
            self.frames += 1
        if self.alarms >= self.ALARMS:
            return self._touched()
        passed = self.limit.passed()
        if passed is not None:
            raise NoContact(passed)
        return super().update()

    def arrived(self) -> Status:
        """Give up: nothing was met on the whole way."""
        raise NoContact(f"nothing was met down to {self.goal * 1e3:.0f} mm")

    def _touched(self) -> Status:
        self.free_membrane = replace(self.free, frames=self.free.frames + self.frames)
        self.reason = ""
        return Status.SUCCESS
