"""Harmonic functions around an ellipse in a membrane whose tensions along i and j differ.

Outside the contact the height obeys T_i z_xx + T_j z_yy = 0, Laplace's equation once y is divided by k = sqrt(T_j / T_i).
Joukowski's map, zeta + m / zeta = w with w = (x + i y / k) / s, takes the outside of the contact to the outside of
the unit circle, and log zeta = tau + i psi gives functions that are harmonic and vanish on the rim, tau = 0
(Milne-Thomson, Theoretical Hydrodynamics, section 6.30).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["COUNT", "Rim", "skirt"]

Array = npt.NDArray[np.float64]

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
    from stretch_bt.perception.size.conformal_kernel import fill_skirt

    x, y = np.ascontiguousarray(x, dtype=np.float64), np.ascontiguousarray(y, dtype=np.float64)
    fall, outside = np.empty(x.size), np.empty(x.size)
    by_rim, basis = np.empty((5, x.size)), np.empty((COUNT, x.size))
    place = np.array([rim.x, rim.y, rim.half_i, rim.half_j, rim.k])
    fill_skirt(place, np.ascontiguousarray(coefficients), x, y, KINK, fall, by_rim, basis, outside)
    return fall, by_rim, basis, outside
