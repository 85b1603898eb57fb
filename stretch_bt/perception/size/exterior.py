"""The outside of a closed curve mapped from the outside of the unit disc, where harmonic functions are known.

f(z) = C z + sum_n c_n z^-n. For a parallelogram with the interior angle pi g, f'(z) = C (1 - a / z^2)^(1 - g) (1 - b / z^2)^g
(Driscoll and Trefethen, Schwarz-Christoffel Mapping, 2002, section 4.4); its series ends where what is left out rounds the
corners by less than the fillet of an object's edges does.
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
FLATTEST = 0.15  # share of C below which f', 0 at a corner, counts as this share
_TURNS = 6  # of Newton's method for the corners, and for places
_NODES = 16
_STEP = 1e-4


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

    def inverse(self, w: Complex) -> Complex:
        """Return z with f(z) = w for places w, m, outside the curve, by Newton's method; |z| >= 1."""
        z = _ellipse(w / self.scale, complex(self.series[0]) / self.scale)
        for _ in range(_TURNS):
            value, slope = self(z)
            z = _outside(z - (value - w) / slope)
        return z

    def turn(self, z: Complex) -> Complex:
        """Return d log z / dw, limited at corners."""
        _, slope = self(z)
        size = np.maximum(np.abs(slope), 1e-12 * self.scale)
        return 1.0 / (z * slope * np.maximum(1.0, FLATTEST * self.scale / size))

    def powers(self, z: Complex) -> Complex:
        """Return z and the powers of the series (n, 1 + terms): what f varies by with `scale` and `series`."""
        steps = np.empty((z.size, 1 + len(self.series)), dtype=np.complex128)
        steps[:, 0] = z
        if len(self.series):
            steps[:, 1] = 1.0 / z
            steps[:, 2:] = (steps[:, 1] ** self.stride)[:, None]
            steps[:, 1:] = np.cumprod(steps[:, 1:], axis=1)
        return steps


def parallelogram_maps(first: Complex, second: Complex) -> tuple[Array, Complex]:
    """Return C (m,) and the series (m, TERMS) with stride 2 of the parallelograms with these sides (m,), about 0.

    `second` lies to the left of `first`.
    """
    angle = np.angle(second / first) / np.pi
    p, q = 1.0 - angle, angle
    between = _between(np.log(np.abs(first / second)), p, q)
    corner = np.exp(1j * between)
    # the image of the arc between the two corners runs against `first`, which tells how far the disc is turned
    edge = -first / _edge(between, p, q)
    scale = np.abs(edge)
    turned = (edge / scale)[:, None] ** (2 * np.arange(1, TERMS + 1))
    return scale, scale[:, None] * turned * _series(np.conj(corner), corner, p, q)


def _outside(z: Complex) -> Complex:
    size = np.abs(z)
    return np.asarray(z / np.clip(size, 1e-9, 1.0))


def _ellipse(w: Complex, c: complex) -> Complex:
    """Return the larger root of z + c / z = w."""
    half = 0.5 * w
    root = np.sqrt(half * half - c)
    root = np.where((np.conj(half) * root).real < 0.0, -root, root)
    return _outside(half + root)


@lru_cache(maxsize=1)
def _quadrature() -> tuple[Array, Array]:
    """Return nodes and weights on 0..1 that bear powers between 0 and 1 at both ends."""
    t, w = np.polynomial.legendre.leggauss(_NODES)
    u = 0.5 * np.pi * (t + 1.0)
    return 0.5 * (1.0 - np.cos(u)), 0.25 * np.pi * w * np.sin(u)


def _length(between: Array, p: Array, q: Array) -> Array:
    """Return the length, over C, of the image of the arc of the unit circle between two corners."""
    nodes, weights = _quadrature()
    t = between[..., None] * nodes
    first, second = 2.0 * np.sin(t), 2.0 * np.sin(between[..., None] * (1.0 - nodes))
    return np.asarray(between * ((first ** p[..., None] * second ** q[..., None]) @ weights))


def _between(log_ratio: Array, p: Array, q: Array) -> Array:
    """Return the angle between two corners on the unit circle, for the logarithm of the ratio of the sides."""
    ratio = np.exp(0.5 * log_ratio)
    angle = np.pi * ratio / (1.0 + ratio)
    for _ in range(_TURNS):
        both = np.stack([angle, angle + _STEP])
        miss = np.log(_length(both, p, q) / _length(np.pi - both, q, p)) - log_ratio
        new = angle - miss[0] * _STEP / (miss[1] - miss[0])
        angle = np.clip(new, 0.5 * angle, 0.5 * (angle + np.pi - 2.0 * _STEP))
    return np.asarray(angle)


def _edge(between: Array, p: Array, q: Array) -> Complex:
    """Return f(e^(i between / 2)) - f(e^(-i between / 2)) for C = 1.

    On the unit circle 1 - e^(2 i (c - t)) = 2 sin(t - c) e^(i (c - t + pi / 2)), so that the sum of the phases stays.
    """
    phase = 0.5 * np.pi * (1.0 + p - q) + 0.5 * between * (q - p)
    return np.asarray(_length(between, p, q) * np.exp(1j * phase))


def _series(a: Complex, b: Complex, p: Array, q: Array) -> Complex:
    """Return c_n (m, TERMS) in z + sum c_n z^(-1 - 2 n), the integral of (1 - a / z^2)^p (1 - b / z^2)^q, p + q = 1."""
    d = np.zeros((len(a), TERMS + 1), dtype=np.complex128)
    d[:, 0] = 1.0
    for n in range(TERMS):
        d[:, n + 1] = ((a + b) * n - (a * p + b * q)) * d[:, n]
        if n:
            d[:, n + 1] -= a * b * (n - 2.0) * d[:, n - 1]
        d[:, n + 1] /= n + 1
    return np.asarray(d[:, 1:] / (1.0 - 2.0 * np.arange(1, TERMS + 1)))
