"""Where the hand is, by what a controller sends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from stretch_bt.frames import Pose
from stretch_bt.hardware.transforms import Array, inverse, pose_of, six, transform, transform_of
from stretch_bt.hardware.ur.kinematics import MODELS
from stretch_bt.hardware.ur.messages import ControllerSettings, Six

__all__ = ["Mounting"]


class Mounting:
    """Places of the hand in the robot's base, as position, m, and rotation vector, rad, and in the world.

    Parameters
    ----------
    settings
        Settings with the model, the base in the world and the hand at the flange.
    """

    def __init__(self, settings: ControllerSettings) -> None:
        self._kinematics = MODELS[settings.model]
        self._base, self._into_base = transform(settings.base), inverse(transform(settings.base))
        self._hand = transform(settings.hand)

    def deviation(self, q: Sequence[float], hand: Six) -> Six:
        """Return where the hand is seen from where nominal kinematics have it at joint angles, rad."""
        return _six(inverse(self._nominal(q)) @ transform(hand))

    def corrected(self, q: Sequence[float], deviation: Six) -> Six:
        """Return where the hand is by joint angles, rad, and its deviation from nominal kinematics."""
        return _six(self._nominal(q) @ transform(deviation))

    def in_world(self, hand: Six) -> Pose:
        """Return the pose in the world of a hand in the base."""
        return pose_of(self._base @ transform(hand))

    def in_base(self, pose: Pose) -> Six:
        """Return a pose in the world as one in the base."""
        return _six(self._into_base @ transform_of(pose))

    def _nominal(self, q: Sequence[float]) -> Array:
        return self._kinematics.forward(q) @ self._hand


def _six(made: Array) -> Six:
    return cast(Six, tuple(six(made)))
