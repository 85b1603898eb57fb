"""Noise and offset of a controller's estimate of the wrench on its tool."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stretch_bt.hardware.transforms import Array

__all__ = ["CB3", "E_SERIES", "ForceNoise", "NoisyForce"]


class ForceNoise(NamedTuple):
    """Standard deviations an axis, white from cycle to cycle, and the length of an offset that is constant in a run; N and N m."""

    force: float
    torque: float
    offset: float


#: The estimate of a CB3 comes from joint currents. Users of UR's forum measured a standard deviation of 3.6 N an axis; the maker states
#: an accuracy of 10 N and 5 N m. Torque is in the same proportion.
CB3 = ForceNoise(3.6, 1.8, 6.0)
#: The sensor of an e-series is in its flange; by UR's data sheet its accuracy is 4 N and 0.3 N m. Its noise is assumed to be a ninth of a
#: CB3's: forces of 1 to 10 N were measured with a mean deviation of 0.38 N (Sensors 2026, doi 10.3390/s26051709).
E_SERIES = ForceNoise(0.4, 0.03, 2.0)


class NoisyForce:
    """The errors of one controller's estimate, drawn once a cycle.

    Parameters
    ----------
    noise
        How large they are.
    seed
        Seed of the draws.
    """

    def __init__(self, noise: ForceNoise, seed: int) -> None:
        self._random = np.random.default_rng((seed, 0xF0))
        self._sd = np.repeat([noise.force, noise.torque], 3)
        way = self._random.normal(size=3)
        self._offset = np.concatenate([noise.offset * way / np.linalg.norm(way), np.zeros(3)])
        self.error: Array = self._offset

    def draw(self, force_sd: float | None = None) -> None:
        """Take the errors of the next cycle; `force_sd`, N an axis, where another one than the controller's own is given."""
        drawn = self._random.standard_normal(6)
        self.error = self._offset + self._sd * drawn
        if force_sd is not None:
            self.error[:3] = self._offset[:3] + force_sd * drawn[:3]
