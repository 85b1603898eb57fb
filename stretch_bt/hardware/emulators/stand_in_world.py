"""What stands around the stand-ins of one process: the fingers, which they share, and nothing that the hand touches."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.motion.profile import Profile
from stretch_bt.hardware.simulated.track import Track

if TYPE_CHECKING:
    from stretch_bt.hardware.emulators.twin_camera import TwinCamera

__all__ = ["StandInWorld", "begin_fingers", "brake_fingers"]

_ACCELERATION = 2.0
_NOTHING = Wrench((0.0, 0.0, 0.0))


class StandInWorld:
    """Shared by the stand-ins of one process; safe to use from any thread.

    Parameters
    ----------
    geometry
        The hand; the fingers stand at its `rest_opening` at first.
    now
        The clock that motions go by, s.
    seed
        Seed of everything random.
    """

    def __init__(
        self, geometry: HandGeometry | None = None, *, now: Callable[[], float] = time.monotonic, seed: int = 0
    ) -> None:
        self.now = now
        self.seed = seed
        self.geometry = geometry or HandGeometry()
        self.fingers: Track[float] = Track(self.geometry.rest_opening)
        self._moving = threading.Lock()

    def opening(self) -> float:
        """Return the opening of the fingers now, m."""
        with self._moving:
            return self.fingers.at(self.now())

    def move_fingers(self, to: float, speed: float) -> float:
        """Start moving the fingers to an opening, m, at a speed, m/s, and return when they will be there, s."""
        with self._moving:
            return begin_fingers(self.fingers, self.now(), to, speed)

    def stop_fingers(self) -> None:
        """Brake."""
        with self._moving:
            brake_fingers(self.fingers, self.now())

    def place_hand(self, pose: Pose) -> None:
        """Take note that an arm has the hand there now."""

    def wrench(self, kind: str) -> Wrench:
        """Return what the world does to the hand, in world axes, as a kind of device (`Arm`, `ForceSensor`) feels it, without its noise."""
        return _NOTHING

    def force_noise(self, kind: str) -> float | None:
        """Return the standard deviation, N an axis, that the scene gives a kind of device; None where it says nothing of it."""
        return None

    def camera(self, rate: int) -> TwinCamera | None:
        """Return what a camera sees at a rate, Hz; None where there is nothing to see."""
        return None


def begin_fingers(fingers: Track[float], time: float, to: float, speed: float) -> float:
    """Start a motion of the fingers from where they are at a time, s, to an opening, m, and return when it ends, s."""
    here = fingers.at(time)
    length, sign = abs(to - here), math.copysign(1.0, to - here)
    profile = Profile.trapezoid(length, speed, _ACCELERATION)
    return fingers.begin(time, lambda gone: to if gone >= length else here + sign * gone, profile)


def brake_fingers(fingers: Track[float], time: float) -> None:
    """Stop the fingers from a time, s, on."""
    fingers.stop(time, _ACCELERATION)
