"""What stands around the stand-ins: the fingers, and with a scene the twin that they act on together."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Wrench
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.simulated.profile import Profile
from stretch_bt.hardware.simulated.track import Track

if TYPE_CHECKING:
    from stretch_bt.hardware.simulated.twin import Twin
    from stretch_bt.simulation.scene import Scene

__all__ = ["Stage"]

_ACCELERATION = 2.0
#: how often the contact is worked out for a device that asks all the time, s
_INTERVAL = 0.02


class Stage:
    """Shared by the stand-ins of one process; every use of the twin is under `lock`.

    Parameters
    ----------
    scene
        What the twin simulates; without one nothing is in contact.
    geometry
        The hand; the fingers stand at its `rest_opening` at first.
    now
        The clock that motions go by, s.
    seed
        Of everything random.
    """

    def __init__(
        self,
        scene: Scene | None = None,
        geometry: HandGeometry | None = None,
        *,
        now: Callable[[], float] = time.monotonic,
        seed: int = 0,
    ) -> None:
        self.now = now
        self.seed = seed
        self.lock = threading.RLock()
        self.geometry = geometry or HandGeometry()
        self.twin: Twin | None = None
        self._own: Track[float] = Track(self.geometry.rest_opening)
        self._wrench = Wrench((0.0, 0.0, 0.0))
        self._next = -math.inf
        if scene is not None:
            from stretch_bt.hardware.simulated.twin import Twin

            start = now()
            self.now = lambda: now() - start
            self.twin = Twin(scene, self.geometry, self.now, seed)

    def opening(self) -> float:
        """Return the opening of the fingers now, m."""
        with self.lock:
            return self._fingers.at(self.now())

    def move_fingers(self, to: float, speed: float) -> float:
        """Start moving the fingers, and return when they will be there, s."""
        with self.lock:
            here = self.opening()
            length, sign = abs(to - here), math.copysign(1.0, to - here)
            profile = Profile.trapezoid(length, speed, _ACCELERATION)

            def path(gone: float) -> float:
                return to if gone >= length else here + sign * gone

            if self.twin is not None:
                return self.twin.move_fingers(path, profile)
            return self._own.begin(self.now(), path, profile)

    def stop_fingers(self) -> None:
        """Brake."""
        with self.lock:
            if self.twin is not None:
                self.twin.remember()
            self._fingers.stop(self.now(), _ACCELERATION)

    def wrench(self) -> Wrench:
        """Return what the world does to the hand, in world axes, with the scene's noise; the last answer where there is none."""
        with self.lock:
            if self.twin is not None and time.monotonic() >= self._next:
                from stretch_bt.hardware.simulated.samples import sample_wrench

                self._next = time.monotonic() + _INTERVAL
                with suppress(NoEquilibrium):
                    self._wrench = sample_wrench(self.twin, "ForceSensor", "force_sensor").value
            return self._wrench

    @property
    def _fingers(self) -> Track[float]:
        return self._own if self.twin is None else self.twin.fingers
