"""The outside of a closed curve mapped from the outside of the unit disc, where harmonic functions are known.

f(z) = C z + sum_n c_n z^-n. For a parallelogram with the interior angle pi g, f'(z) = C (1 - a / z^2)^(1 - g) (1 - b / z^2)^g
(Driscoll and Trefethen, Schwarz-Christoffel Mapping, 2002, section 4.4); its series ends where the terms left out round the
corners by less than the fillet of an object's edges do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

__all__ = ["ExteriorMap", "parallelogram_maps"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

TERMS = 10  # of a parallelogram's series, the odd powers
FLATTEST = 0.05  # share of C below which f', 0 at a corner, counts as this share
_NODES = 16


@dataclass(frozen=True, slots=True)
class ExteriorMap:
    """f(z) = scale z + sum_n series[n] z^-(1 + n stride); lengths in m, `scale` real, so that far directions are kept."""

    scale: float
    series: Complex
    stride: int

    def __call__(self, z: Complex) -> tuple[Complex, Complex]:
        """Return f and f' outside the unit disc."""
        back = 1.0 / z
        s = back**self.stride
        value, slope = np.zeros_like(s), np.zeros_like(s)
        for n in range(len(self.series) - 1, -1, -1):
            value = s * value + self.series[n]
            slope = s * slope - (1 + n * self.stride) * self.series[n]
        return self.scale * z + back * value, self.scale + back * back * slope

    def turn(self, z: Complex) -> Complex:
        """Return d log z / dw, limited at corners."""
        _, slope = self(z)
        size = np.maximum(np.abs(slope), 1e-12 * self.scale)
        return 1.0 / (z * slope * np.maximum(1.0, FLATTEST * self.scale / size))


def parallelogram_maps(first: Complex, second: Complex) -> tuple[Array, Complex]:
    """Return C (m,) and the series (m, TERMS) with stride 2 of the parallelograms with these sides (m,), about 0.

    `second` lies to the left of `first`.

    On the unit circle 1 - e^(2 i (c - t)) = 2 sin(t - c) e^(i (c - t + pi / 2)), so that the image of the arc between two
    corners, at -d / 2 and d / 2, is straight; the ratio of two such arcs gives d, and the direction of one the turn of
    the disc.
    """
    from stretch_bt.perception.size.corner_kernel import fill_maps

    scale, series = np.empty(len(first)), np.empty((len(first), TERMS), dtype=np.complex128)
    fill_maps(np.ascontiguousarray(first), np.ascontiguousarray(second), *_quadrature(), scale, series)
    return scale, series


@lru_cache(maxsize=1)
def _quadrature() -> tuple[Array, Array]:
    """Return nodes and weights on 0..1 that bear powers between 0 and 1 at both ends."""
    t, w = np.polynomial.legendre.leggauss(_NODES)
    u = 0.5 * np.pi * (t + 1.0)
    return 0.5 * (1.0 - np.cos(u)), 0.25 * np.pi * w * np.sin(u)
