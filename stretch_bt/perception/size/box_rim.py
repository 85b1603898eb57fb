"""The rim of a rectangular contact, and the skirt around it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.around import skirt_around, slope_sums
from stretch_bt.perception.size.exterior import ExteriorMap, parallelogram_maps

__all__ = ["BoxRim"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

NEAR = 1.5e-3  # m inside the rim beyond which the face is flat
MIDDLE = 0.35  # of a side, to either hand of its middle, over which its slope is averaged
STEPS = np.array([1e-5, 1e-6, 1e-6, 1e-5])  # of k, the two sides, m, and the rotation, rad


@dataclass(frozen=True, slots=True)
class BoxRim:
    """Centre (x, y) and sides, m, rotation of the first side from i, rad, and ln(T_j / T_i)."""

    x: float
    y: float
    first: float
    second: float
    rotation: float
    log_ratio: float

    @property
    def k(self) -> float:
        """Square root of the tension ratio."""
        return float(np.exp(0.5 * self.log_ratio))

    def along_sides(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return places in the axes of the sides, m."""
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        return c * (x - self.x) + s * (y - self.y), c * (y - self.y) - s * (x - self.x)

    def outside(self, x: Array, y: Array) -> Array:
        """Return how far places lie outside the rim, m, negative inside; beyond corners the larger of both distances."""
        u, v = self.along_sides(x, y)
        return np.maximum(np.abs(u) - 0.5 * self.first, np.abs(v) - 0.5 * self.second)

    def map(self) -> ExteriorMap:
        """Return the map of the outside in the plane with y over k."""
        scale, series = parallelogram_maps(*_sides(self._sizes()[None]))
        return ExteriorMap(float(scale[0]), series[0], 2)

    def slopes(self, skirt: Array) -> tuple[float, float]:
        """Return how steep the skirt (COUNT,), m, leaves the ends of the first side and of the second, mean of both."""
        z = _circle()
        outline, k = self.map(), self.k
        place, slope = outline(z)
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        x, y = place.real, k * place.imag
        u, v = np.abs(c * x + s * y) / self.first, np.abs(c * y - s * x) / self.second
        run = 1j * z * slope
        length = np.hypot(run.real, k * run.imag)
        steep = (skirt @ slope_sums(outline, k, z)) * length
        ends = [(u > v) & (v < MIDDLE), (v > u) & (u < MIDDLE)]
        return tuple(float(steep[e].sum() / max(length[e].sum(), 1e-12)) for e in ends)  # type: ignore[return-value]

    def skirt(self, coefficients: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Return how far the skirt falls below the face (n,), its derivatives (6, n), and its functions (COUNT, n).

        The derivatives are by x, y, the two sides (per m), rotation and log_ratio. `coefficients` are in m.
        """
        sizes = np.tile(self._sizes(), (5, 1))
        sizes[np.arange(1, 5), [3, 0, 1, 2]] += STEPS
        scale, series = parallelogram_maps(*_sides(sizes))
        by_size = np.column_stack([scale[1:] - scale[0], series[1:] - series[0]]) / STEPS[:, None]
        outline = ExteriorMap(float(scale[0]), series[0], 2)
        fall, by, basis = skirt_around(outline, by_size, self.k, coefficients, *self._mirrored(x, y))
        by[2] *= 0.5 * self.k
        return fall, by[[0, 1, 3, 4, 5, 2]], basis

    def _sizes(self) -> Array:
        return np.array([self.first, self.second, self.rotation, self.k])

    def _mirrored(self, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Return places about the centre, and 1; -1 where a place inside was mirrored at a side, 0 where it is far inside.

        tau is odd in the distance from a straight side, and the map has no inside.
        """
        u, v = self.along_sides(x, y)
        past_u, past_v = np.abs(u) - 0.5 * self.first, np.abs(v) - 0.5 * self.second
        outside = np.maximum(past_u, past_v)
        inside = outside < 0.0
        u = np.where(inside & (past_u >= past_v), np.sign(u) * (self.first - np.abs(u)), u)
        v = np.where(inside & (past_u < past_v), np.sign(v) * (self.second - np.abs(v)), v)
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        sign = np.where(inside, np.where(outside > -NEAR, -1.0, 0.0), 1.0)
        return c * u - s * v, s * u + c * v, sign


def _sides(sizes: Array) -> tuple[Complex, Complex]:
    """Return both sides (m,) in the plane with y over k, from rows of first, second, rotation, k."""
    first, second, rotation, k = sizes.T
    c, s = np.cos(rotation), np.sin(rotation)
    return first * (c + 1j * s / k), second * (-s + 1j * c / k)


@lru_cache(maxsize=1)
def _circle() -> Complex:
    """Return places on the unit circle, none at a corner of a rectangle along the axes."""
    return np.asarray(np.exp(1j * (np.arange(96) + 0.31) * 2.0 * np.pi / 96))
