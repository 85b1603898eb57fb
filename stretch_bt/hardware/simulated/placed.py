"""Where a hand is, and where its arm says that it is."""

from __future__ import annotations

from typing import NamedTuple

from stretch_bt.frames import Pose
from stretch_bt.hardware.motion.path import between

__all__ = ["Placed"]


class Placed(NamedTuple):
    """Where the arm says that the hand is, and where it is."""

    told: Pose
    true: Pose

    @staticmethod
    def at(pose: Pose) -> Placed:
        """Return a hand that is where the arm says."""
        return Placed(pose, pose)

    @staticmethod
    def between(one: Placed, other: Placed, part: float) -> Placed:
        """Return what lies between two of them, at a part of the way."""
        return Placed(between(one.told, other.told, part), between(one.true, other.true, part))
