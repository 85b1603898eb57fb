"""Harmonic functions around an ellipse in a membrane whose tensions along i and j differ.

Outside the contact the height obeys T_i z_xx + T_j z_yy = 0, Laplace's equation once y is divided by k = sqrt(T_j / T_i).
Joukowski's map, zeta + m / zeta = w with w = (x + i y / k) / s, takes the outside of the contact to that of the unit
circle, and log zeta = tau + i psi gives functions that are harmonic and vanish on the rim, tau = 0
(Milne-Thomson, Theoretical Hydrodynamics, section 6.30).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["COUNT", "Rim", "skirt"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

COUNT = 7  # skirt functions; the last two are not harmonic and stand for a tension that changes with the slope
KINK = 0.45e-3  # m, half the width over which the rim is rounded by its fillet and by the cells


@dataclass(frozen=True, slots=True)
class Rim:
    """An ellipse with centre (x, y), half axes along i and j, m, and ln(T_j / T_i)."""

    x: float
    y: float
    half_i: float
    half_j: float
    log_ratio: float

    @property
    def k(self) -> float:
        """Square root of the tension ratio."""
        return float(np.exp(0.5 * self.log_ratio))

    def slopes(self, skirt: Array) -> tuple[float, float]:
        """Return how steep the skirt with coefficients (7,), m, leaves the rim along i and along j, both sides' mean."""
        return (
            float(skirt[0] + skirt[3]) * self.k / self.half_j,
            float(skirt[0] - skirt[3]) / (self.half_i * self.k),
        )


def skirt(rim: Rim, coefficients: Array, x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
    """Return how far the skirt falls below the face, its derivatives, and how far each place is outside the rim.

    Parameters
    ----------
    coefficients : (7,), m
    x, y : (n,), m

    Returns
    -------
    fall : (n,), m
    by_rim : (5, n)
        By x, y, half_i, half_j (each per m) and by log_ratio.
    basis : (7, n)
        The skirt functions: by each coefficient.
    outside : (n,), m
        Signed distance from the rim, right to first order.
    """
    k, a, b = rim.k, rim.half_i, rim.half_j / rim.k
    s, m = 0.5 * (a + b), (a - b) / (a + b)
    w: Complex = np.empty(x.size, dtype=np.complex128)
    w.real, w.imag = (x - rim.x) / s, (y - rim.y) / (k * s)
    zeta = _outer_root(w, m)
    turn = 1.0 / _away_from_zero(zeta - m / zeta)
    radius = np.maximum(np.abs(zeta), 1e-12)
    tau, unit = np.log(radius), zeta / radius
    steepness = np.hypot(turn.real, turn.imag / k) / s
    outside = tau / steepness
    basis, by_tau, by_psi = _functions(tau, unit, KINK * steepness)
    along, around = coefficients @ by_tau, coefficients @ by_psi
    log_by = np.empty((5, x.size), dtype=np.complex128)
    log_by[0] = turn * (-1.0 / s)
    log_by[1] = turn * (-1j / (s * k))
    by_s = -w / s
    by_m = -1.0 / zeta
    by_a = turn * (0.5 * by_s + (1.0 - m) / (2.0 * s) * by_m)
    by_b = turn * (0.5 * by_s - (1.0 + m) / (2.0 * s) * by_m)
    log_by[2] = by_a
    log_by[3] = by_b / k
    log_by[4] = -0.5 * (b * by_b + turn * (1j * w.imag))
    by_rim = along * log_by.real + around * log_by.imag
    return coefficients @ basis, by_rim, basis, outside


def _outer_root(w: Complex, m: float) -> Complex:
    """Return the larger root of zeta + m / zeta = w."""
    root = np.sqrt(w * w - 4.0 * m)
    root = np.where((w.real * root.real + w.imag * root.imag) < 0.0, -root, root)
    return _away_from_zero(0.5 * (w + root))


def _away_from_zero(values: Complex) -> Complex:
    return np.where(np.abs(values) < 1e-9, 1e-9 + 0j, values)


def _functions(tau: Array, unit: Complex, width: Array) -> tuple[Array, Array, Array]:
    """Return the skirt functions (7, n) and their derivatives by tau and by psi; all vanish inside the rim.

    The kink is rounded to (tau + width)^2 / (4 width), which keeps the line outside as it is.
    """
    t = np.where(tau > width, tau, np.maximum(tau + width, 0.0) ** 2 / (4.0 * width))
    slope = np.where(tau > width, 1.0, np.maximum(tau + width, 0.0) / (2.0 * width))
    t = np.minimum(t, 4.0)
    c1, s1 = unit.real, unit.imag
    c2, s2 = c1 * c1 - s1 * s1, 2.0 * c1 * s1
    grow = np.exp(t)
    shrink = 1.0 / grow
    sinh1, cosh1 = 0.5 * (grow - shrink), 0.5 * (grow + shrink)
    sinh2, cosh2 = 2.0 * sinh1 * cosh1, 1.0 + 2.0 * sinh1 * sinh1
    half = 0.5 * t * t
    zero: Any = np.zeros_like(t)
    basis = np.array([t, sinh1 * c1, sinh1 * s1, 0.5 * sinh2 * c2, 0.5 * sinh2 * s2, half, half * c2])
    by_tau = slope * np.array([zero + 1.0, cosh1 * c1, cosh1 * s1, cosh2 * c2, cosh2 * s2, t, t * c2])
    by_psi = np.array([zero, -sinh1 * s1, sinh1 * c1, -sinh2 * s2, sinh2 * c2, zero, -2.0 * half * s2])
    return basis, by_tau, by_psi
