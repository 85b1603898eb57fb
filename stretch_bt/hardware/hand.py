"""The hand: the lengths of its membrane, fingers and camera, and the height of first contact."""

from __future__ import annotations

from dataclasses import dataclass, field

from stretch_bt.frames import Pose
from stretch_bt.hardware.transforms import rotation_vector

__all__ = ["Hand", "HandGeometry"]


@dataclass(frozen=True, slots=True)
class HandGeometry:
    """Lengths of the hand, m; `rest_opening` is the gripper's opening at stretch 0.

    (`aim_x`, `aim_y`) is where the camera's axis meets the membrane's plane, membrane frame, and `yaw`, rad, its turn about that frame's z.
    """

    gauge: float = 0.100
    width: float = 0.090
    thickness: float = 0.002
    rest_opening: float = 0.055
    plane_distance: float = 0.200
    aim_x: float = 0.0
    aim_y: float = 0.0
    yaw: float = 0.0

    def seen_from(self, pose: Pose) -> Pose:
        """Return the pose of the hand from which the camera, if it stood and looked straight, would see what it sees."""
        if not (self.aim_x or self.aim_y or self.yaw):
            return pose
        turn = pose.matrix()
        shift = turn @ [self.aim_x, -self.aim_y, 0.0]
        x, y, z = (float(p + s) for p, s in zip(pose.position, shift, strict=True))
        a, b, c = rotation_vector(turn @ Pose(rotation=(0.0, 0.0, -self.yaw)).matrix()).tolist()
        return Pose((x, y, z), (a, b, c))

    def reach(self, stretch: float) -> float:
        """Return how high the membrane can be lifted at a stretch, m: with flanks of 45 degrees from both clamps to the top.

        It is stretched by two fifths more there; presses are known up to a third of that height.
        """
        return 0.5 * (self.gauge + stretch)

    def opening(self, stretch: float) -> float:
        """Return the gripper opening, m, that gives a stretch, m."""
        return self.rest_opening + stretch

    def stretch(self, opening: float) -> float:
        """Return the stretch, m, that a gripper opening, m, gives."""
        return opening - self.rest_opening


@dataclass(slots=True)
class Hand:
    """The hand of a run: its geometry, and the height of first contact once a node has found it."""

    geometry: HandGeometry = field(default_factory=HandGeometry)
    contact_height: float | None = None

    def depth(self, hand_height: float) -> float | None:
        """Return how far the hand is past first contact, m, or None before contact was found."""
        return None if self.contact_height is None else self.contact_height - hand_height
