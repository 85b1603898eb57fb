"""What stands around the stand-ins: the fingers, and with a scene the twin that they act on together."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.emulators.trace import Trace
from stretch_bt.hardware.emulators.turns import Turns
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.simulated.profile import Profile
from stretch_bt.hardware.simulated.track import Track

if TYPE_CHECKING:
    from stretch_bt.hardware.simulated.twin import Twin
    from stretch_bt.simulation.scene import Scene

__all__ = ["Stage"]

_ACCELERATION = 2.0
_TOUCHES = 3


class Stage:
    """Shared by the stand-ins of one process.

    Every use of the twin is under `lock`, and may take as long as the membrane takes to be solved; where the fingers are is known
    without it, so that a gripper answers meanwhile.

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
        self.lock = Turns()
        self._moving = threading.Lock()
        self.geometry = geometry or HandGeometry()
        self.twin: Twin | None = None
        self._own: Track[float] = Track(self.geometry.rest_opening)
        self._wrench = Wrench((0.0, 0.0, 0.0))
        self._trace: Trace | None = None
        if scene is not None:
            from stretch_bt.hardware.simulated.twin import Twin

            start = now()
            self.now = lambda: now() - start
            _rehearse(Twin(scene, self.geometry, lambda: 0.0, seed))
            self.twin = Twin(scene, self.geometry, self.now, seed)

    def opening(self) -> float:
        """Return the opening of the fingers now, m."""
        with self._moving:
            return self._fingers.at(self.now())

    def move_fingers(self, to: float, speed: float) -> float:
        """Start moving the fingers, and return when they will be there, s."""
        self._remember()
        with self._moving:
            now = self.now()
            here = self._fingers.at(now)
            length, sign = abs(to - here), math.copysign(1.0, to - here)
            profile = Profile.trapezoid(length, speed, _ACCELERATION)
            return self._fingers.begin(now, lambda gone: to if gone >= length else here + sign * gone, profile)

    def stop_fingers(self) -> None:
        """Brake."""
        self._remember()
        with self._moving:
            self._fingers.stop(self.now(), _ACCELERATION)

    def place_hand(self, pose: Pose) -> None:
        """Take note that an arm has the hand there now; without one it hangs where the twin has it."""
        if self._trace is None:
            self._trace = Trace(pose)
            if self.twin is not None:
                with self.lock:
                    self.twin.hand = self._trace
        self._trace.note(self.now(), pose)

    def wrench(self) -> Wrench:
        """Return what the world does to the hand, in world axes, with the scene's noise; the last answer where there is none."""
        return self._felt_by("ForceSensor", "force_sensor")

    def arm_wrench(self) -> Wrench:
        """Return the same as the arm feels it."""
        return self._felt_by("Arm", "arm")

    def _felt_by(self, kind: str, name: str) -> Wrench:
        with self.lock:
            if self.twin is not None:
                from stretch_bt.hardware.simulated.samples import sample_wrench

                with suppress(NoEquilibrium):
                    self._wrench = sample_wrench(self.twin, kind, name).value
            return self._wrench

    def _remember(self) -> None:
        """Take a twin that has a memory to this moment, before its fingers go elsewhere."""
        if self.twin is not None and self.twin.world.memory is not None:
            with self.lock:
                self.twin.remember()

    @property
    def _fingers(self) -> Track[float]:
        return self._own if self.twin is None else self.twin.fingers


def _rehearse(twin: Twin) -> None:
    """Press a twin that nobody looks at, so that what is loaded or compiled on the way keeps no robot waiting later."""
    touched = 0
    with suppress(NoEquilibrium):
        for millimetres in range(200, 0, -1):
            twin.place(Pose((0.0, 0.0, millimetres / 1000)))
            touched += twin.contact(0.0).force[2] > 0
            if touched > _TOUCHES:
                return
