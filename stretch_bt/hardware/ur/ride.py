"""One motion of the hand along straight lines, as a setpoint for each moment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.motion.path import LEVER, PosePath
from stretch_bt.hardware.motion.profile import Profile

__all__ = ["Ride"]

#: how far the hand may be behind its setpoint: m, and s of its way
_BEHIND, _BEHIND_TIME = 0.0015, 0.3
#: longest time to settle, s, in which the allowed lag shrinks, and the distance from the target at which that ends at once, m
_SETTLING, _SETTLED = 0.5, 5e-5


@dataclass(frozen=True, slots=True)
class Ride:
    """A motion that begins and ends at rest, and how far it is: `gone` is the time of its profile, s, and `asked` when it was set."""

    path: PosePath
    profile: Profile
    speed: float
    tolerance: float
    gone: float = 0.0
    asked: float = math.inf

    @classmethod
    def through(cls, poses: Sequence[Pose], speed: float, acceleration: float, tolerance: float) -> Ride:
        """Return a motion that has not begun.

        Parameters
        ----------
        poses
            Of the hand in the world; the first is where it stands.
        speed, acceleration
            m/s and m/s².
        tolerance
            How far from its target it may end, m.
        """
        path = PosePath(poses)
        return cls(path, Profile.trapezoid(path.length, speed, acceleration), speed, tolerance)

    def at(self, now: float, most: float) -> Ride:
        """Return the motion as it is at a time of a clock; the first call begins it.

        Of a pause in which it was not asked only `most` counts: the setpoint goes on from where it was rather than with a leap.
        """
        return replace(self, gone=self.gone + min(max(now - self.asked, 0.0), most), asked=now)

    @property
    def setpoint(self) -> Pose:
        """Where the hand should be."""
        return self.path.at(self.profile.at(self.gone)[0])

    def judge(self, place: Pose) -> MotionState | str:
        """Return how the motion stands with the hand at a place, or what is wrong."""
        wanted = self.setpoint
        off = max(math.dist(place.position, wanted.position), LEVER * _angle(place, wanted))
        late = max(self.gone - self.profile.duration, 0.0) / _SETTLING
        most = (_BEHIND + _BEHIND_TIME * self.speed) * (1.0 - late)
        if self.gone < self.profile.duration:
            if off > most:
                return f"the arm does not follow: it is {1e3 * off:.1f} mm behind; look for what holds it, and at the speed slider"
            return MotionState.MOVING
        if off <= _SETTLED:
            return MotionState.DONE
        if late < 1.0 and off <= max(most, self.tolerance):
            return MotionState.MOVING
        if off <= self.tolerance:
            return MotionState.DONE
        return f"the arm did not arrive: it is {1e3 * off:.1f} mm off its target; look for what holds it, and at the speed slider"


def _angle(one: Pose, other: Pose) -> float:
    """Return the angle between two orientations, rad: 2 sqrt(2) sin(angle / 2) is how far their matrices are apart."""
    apart = float(np.linalg.norm(one.matrix() - other.matrix()))
    return 2.0 * math.asin(min(apart / math.sqrt(8.0), 1.0))
