"""The rim of a rectangular contact, and the skirt around it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.around import COUNT, KINK, functions, slope_sums
from stretch_bt.perception.size.exterior import ExteriorMap, parallelogram_maps

__all__ = ["BoxRim"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

NEAR = 1.5e-3  # m inside the rim beyond which the face is flat
MIDDLE = 0.35  # of a side, to either hand of its middle, over which its slope is averaged
STEEPEST = 2e3  # 1/m, of tau, to which the rounding of the rim follows it
STEPS = np.array([1e-6, 1e-6, 1e-5, 1e-5])  # of the two sides, m, rotation, rad, and k


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
        outside, places_x, places_y, sign = self._mirrored(x, y)
        near = outside > -NEAR
        sizes = np.tile(self._sizes(), (5, 1))
        sizes[np.arange(1, 5), np.arange(4)] += STEPS
        scale, series = parallelogram_maps(*_sides(sizes))
        outline = ExteriorMap(float(scale[0]), series[0], 2)
        k, y_over = self.k, places_y[near] / self.k
        z = outline.inverse(places_x[near] + 1j * y_over)
        turn = outline.turn(z)
        by_size = np.column_stack([scale[1:] - scale[0], series[1:] - series[0]]) / STEPS[:, None]
        moved = outline.powers(z) @ by_size.T
        log_by = np.empty((6, z.size), dtype=np.complex128)
        log_by[0], log_by[1] = -turn, (-1j / k) * turn
        log_by[2:5] = -moved[:, :3].T * turn
        log_by[5] = -0.5 * (k * moved[:, 3] + 1j * y_over) * turn
        radius = np.abs(z)
        steep = np.minimum(np.hypot(turn.real, turn.imag / k), STEEPEST)
        basis, by_tau, by_psi = functions(sign[near] * np.log(radius), z / radius, KINK * steep)
        all_basis, by_rim = np.zeros((COUNT, x.size)), np.zeros((6, x.size))
        all_basis[:, near] = basis
        by_rim[:, near] = (coefficients @ by_tau) * log_by.real + (coefficients @ by_psi) * log_by.imag
        return coefficients @ all_basis, by_rim, all_basis

    def _sizes(self) -> Array:
        return np.array([self.first, self.second, self.rotation, self.k])

    def _mirrored(self, x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
        """Return distances outside the rim, places about the centre, and -1 where a place inside was mirrored at a side.

        tau is odd in the distance from a straight side, and the map has no inside.
        """
        u, v = self.along_sides(x, y)
        past_u, past_v = np.abs(u) - 0.5 * self.first, np.abs(v) - 0.5 * self.second
        outside = np.maximum(past_u, past_v)
        inside = outside < 0.0
        u = np.where(inside & (past_u >= past_v), np.sign(u) * (self.first - np.abs(u)), u)
        v = np.where(inside & (past_u < past_v), np.sign(v) * (self.second - np.abs(v)), v)
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        return outside, c * u - s * v, s * u + c * v, np.where(inside, -1.0, 1.0)


def _sides(sizes: Array) -> tuple[Complex, Complex]:
    """Return both sides (m,) in the plane with y over k, from rows of first, second, rotation, k."""
    first, second, rotation, k = sizes.T
    c, s = np.cos(rotation), np.sin(rotation)
    return first * (c + 1j * s / k), second * (-s + 1j * c / k)


@lru_cache(maxsize=1)
def _circle() -> Complex:
    """Return places on the unit circle, none at a corner of a rectangle along the axes."""
    return np.asarray(np.exp(1j * (np.arange(192) + 0.37) * 2.0 * np.pi / 192))
