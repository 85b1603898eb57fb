"""The world that the simulated devices of one cell share."""

from __future__ import annotations

import zlib
from collections.abc import Callable

import numpy as np

from stretch_bt.frames import Pose
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.hardware.simulated.path import Placed
from stretch_bt.hardware.simulated.track import Track
from stretch_bt.simulation.scene import Scene
from stretch_bt.simulation.world import Sheet, World

__all__ = ["Twin"]

_HOME = Pose((0.0, 0.0, 0.2))


class Twin:
    """A scene, the hand over it, and what arm and gripper did; without an arm the hand hangs at a height of 200 mm."""

    def __init__(self, scene: Scene, geometry: HandGeometry, now: Callable[[], float], seed: int) -> None:
        self.scene = scene
        self.geometry = geometry
        self.now = now
        self.seed = seed if scene.seed is None else scene.seed
        self.world = World(scene, Sheet(geometry.gauge, geometry.width))
        self.hand: Track[Placed] = Track(Placed(_HOME, _HOME))
        self.fingers: Track[float] = Track(geometry.rest_opening)

    def place(self, home: Pose) -> None:
        """Put the hand where the arm is when it is opened."""
        self.hand = Track(Placed(home, home))

    def stretch(self, time: float) -> float:
        """Return the stretch of the membrane at a time, m."""
        return self.geometry.stretch(self.fingers.at(time))

    def force(self, time: float) -> float:
        """Return the contact force at a time, N."""
        return self.world.contact(self.hand.at(time).true, self.stretch(time)).force

    def truth(self) -> dict[str, float]:
        """Return what a perfect observer would report now, SI."""
        now = self.now()
        return self.world.truth(self.hand.at(now).true, self.stretch(now))

    def random(self, device: str, number: int) -> np.random.Generator:
        """Return the noise source of one sample of a device; the same for the same seed, whatever was asked before."""
        return np.random.default_rng((self.seed, zlib.crc32(device.encode()), number))
