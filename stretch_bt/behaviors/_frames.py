"""What nodes that take frames have in common: fresh frames only, placed in the world."""

from __future__ import annotations

from dataclasses import replace

from stretch_bt import perception
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.interfaces import Arm, DepthCamera, Gripper
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.context import Context

__all__ = ["MAX_AGE", "FrameSource"]

#: how old the latest frame may be, s: a camera at 5 Hz or more passes
MAX_AGE = 0.5


class FrameSource:
    """Hands out frames exposed after the source was made, each once in a run, with the hand's pose and stretch then."""

    def __init__(self, context: Context, camera: DepthCamera, arm: Arm | None, gripper: Gripper | None) -> None:
        self.context = context
        self.camera = camera
        self.arm = arm
        self.gripper = gripper
        self.since = context.now

    def next(self) -> DepthFrame | None:
        """Return a frame not handed out before, or None when there is none yet.

        Raises
        ------
        NoAnswer
            A recording has ended.
        """
        if self.camera.ended:
            raise NoAnswer("the recording has ended")
        reading = self.camera.frame(MAX_AGE)
        key = (FrameSource, id(self.camera))
        if reading.sequence == self.context.memory.get(key) or reading.host_time < self.since - 1e-9:
            return None
        self.context.memory[key] = reading.sequence
        return self._placed(reading.value)

    def corrected(self, frame: DepthFrame) -> DepthFrame:
        """Return a frame, or a mean of frames, without the static error of the camera, where one was learned."""
        pattern = self.context.memory.get((Pattern, id(self.camera)))
        return frame if pattern is None else perception.without_pattern(frame, pattern)

    def learn(self, pattern: Pattern | None) -> None:
        """Correct later frames of this camera in this run by its static error; None ends that."""
        self.context.memory[(Pattern, id(self.camera))] = self.context.memory[Pattern] = pattern

    def _placed(self, frame: DepthFrame) -> DepthFrame:
        geometry = self.context.hand.geometry
        # What the camera's driver knows is of the moment of exposure; what the arm says now is the next best.
        pose, height, stretch = frame.pose, frame.hand_height, frame.stretch
        if pose is None and self.arm is not None:
            now = self.arm.pose(MAX_AGE).value
            pose = now if height is None else now.at_height(height)
            height = pose.height
        if stretch is None and self.gripper is not None:
            stretch = geometry.stretch(self.gripper.opening(MAX_AGE).value)
        pose = None if pose is None else geometry.seen_from(pose)
        stretch = None if stretch is None else max(stretch, 0.0)  # a gripper's counts may end short of the rest length
        distance = frame.plane_distance or geometry.plane_distance
        placed = replace(frame, pose=pose, hand_height=height, stretch=stretch, plane_distance=distance)
        if self.arm is None and self.gripper is None:  # a camera alone may look at anything
            return placed
        return perception.mask_membrane(placed, gauge=geometry.gauge, width=geometry.width, stretch=stretch or 0.0)
