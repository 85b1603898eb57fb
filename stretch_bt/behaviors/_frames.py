"""The common part of nodes that take frames: fresh frames only, placed in the world."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

from stretch_bt import perception
from stretch_bt.errors import DeviceLost, IllConditioned, NoAnswer
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.ages import FRAME, PLACE
from stretch_bt.hardware.interfaces import Arm, DepthCamera, Gripper
from stretch_bt.perception.pattern import Pattern
from stretch_bt.tree.context import Context

__all__ = ["FrameSource", "corrected"]


#: number of the last frame handed out by each camera of a run, by the camera's id, so that two nodes of one tick take different frames
_latest: WeakKeyDictionary[Context, dict[int, int]] = WeakKeyDictionary()


class FrameSource:
    """Hands out frames exposed after the source was made, each once in a run, with the hand's pose and stretch then."""

    def __init__(self, context: Context, camera: DepthCamera, arm: Arm | None, gripper: Gripper | None) -> None:
        self.context = context
        self.camera = camera
        self.arm = arm
        self.gripper = gripper
        self.since = context.now
        self.latest = _latest.setdefault(context, {})

    def next(self) -> DepthFrame | None:
        """Return a frame not handed out before, or None when there is none yet.

        Raises
        ------
        NoAnswer
            A recording has ended.
        """
        if self.camera.ended:
            raise NoAnswer("the recording has ended")
        try:
            reading = self.camera.frame(FRAME)
        except DeviceLost:
            if self.camera.ended:  # since it was asked
                raise NoAnswer("the recording has ended") from None
            raise
        if reading.sequence == self.latest.get(id(self.camera)) or reading.host_time < self.since - 1e-9:
            return None
        self.latest[id(self.camera)] = reading.sequence
        return self._placed(reading.value)

    def _placed(self, frame: DepthFrame) -> DepthFrame:
        geometry = self.context.hand.geometry
        # Pose and stretch from the camera's driver are of the moment of exposure; those from arm and gripper now are the next best.
        pose, height, stretch = frame.pose, frame.hand_height, frame.stretch
        if pose is None and self.arm is not None:
            now = self.arm.pose(PLACE).value
            pose = now if height is None else now.at_height(height)
            height = pose.height
        if stretch is None and self.gripper is not None:
            stretch = geometry.stretch(self.gripper.opening(PLACE).value)
        pose = None if pose is None else geometry.seen_from(pose)
        stretch = None if stretch is None else max(stretch, 0.0)  # a gripper's counts may end short of the rest length
        distance = frame.plane_distance or geometry.plane_distance
        placed = replace(frame, pose=pose, hand_height=height, stretch=stretch, plane_distance=distance)
        if self.arm is None and self.gripper is None:  # a camera alone may look at anything
            return placed
        return perception.mask_membrane(placed, gauge=geometry.gauge, width=geometry.width, stretch=stretch or 0.0)


def corrected(frame: DepthFrame, pattern: Pattern | None, camera: str) -> DepthFrame:
    """Return a frame, or a mean of frames, of the camera of this name without its static error, where one was learned.

    Raises
    ------
    IllConditioned
        The error was learned from another camera.
    """
    if pattern is None:
        return frame
    if pattern.camera not in ("", camera):
        raise IllConditioned(
            f"the static error was learned from camera {pattern.camera!r}, the frame is of {camera!r}; write 'pattern: none', or the key of this one"
        )
    return perception.without_pattern(frame, pattern)
