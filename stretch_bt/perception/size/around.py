"""The skirt around any closed curve whose outside is mapped from that of the unit disc.

With log z = tau + i psi, sinh(n tau) cos(n psi) and its like are harmonic in the plane with y over k = sqrt(T_j / T_i), and
vanish on the rim, tau = 0; tau^2 times cos(n psi) stands for tensions that change from place to place.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.exterior import ExteriorMap

__all__ = ["COUNT", "ORDERS", "functions", "slope_sums"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

KINK = 0.6e-3  # m, half the width over which the rim is rounded by its fillet and by the cells
FARTHEST = 4.0  # tau

# (harmonic or not, order n, cosine or sine)
ORDERS = tuple((kind, n, part) for kind, most in (("sinh", 4), ("square", 2)) for n in range(most + 1) for part in "cs" if n or part == "c")
COUNT = len(ORDERS)


def functions(tau: Array, unit: Complex, width: Array) -> tuple[Array, Array, Array]:
    """Return the skirt functions (COUNT, n) and their derivatives by tau and by psi; all vanish for tau < -width.

    The kink at the rim is rounded to (tau + width)^2 / (4 width), which keeps the line outside as it is.
    """
    rise = np.maximum(tau + width, 0.0)
    far = tau > width
    t = np.minimum(np.where(far, tau, rise * rise / (4.0 * width)), FARTHEST)
    slope = np.where(far, 1.0, rise / (2.0 * width)) * (t < FARTHEST)
    basis, by_tau, by_psi = np.empty((3, COUNT, tau.size))
    grow, turned = np.exp(t), np.ones_like(unit)
    size = np.ones_like(t)
    radial = [(t, np.ones_like(t))]
    around = [turned]
    for n in range(1, 5):
        size, turned = size * grow, turned * unit
        back = 1.0 / size
        radial.append(((size - back) / (2.0 * n), 0.5 * (size + back)))
        around.append(turned)
    half = 0.5 * t * t
    for row, (kind, n, part) in enumerate(ORDERS):
        value, steep = radial[n] if kind == "sinh" else (half, t)
        shape, bend = (around[n].real, -n * around[n].imag) if part == "c" else (around[n].imag, n * around[n].real)
        basis[row], by_tau[row], by_psi[row] = value * shape, slope * steep * shape, value * bend
    return basis, by_tau, by_psi


def slope_sums(outline: ExteriorMap, k: float, z: Complex) -> Array:
    """Return how steep each skirt function (COUNT, n) leaves the rim at places z on the unit circle, 1 over m."""
    turn = outline.turn(z)
    steep = np.hypot(turn.real, turn.imag / k)
    return np.array(
        [
            ((z**n).real if part == "c" else (z**n).imag) * steep if kind == "sinh" else np.zeros_like(steep)
            for kind, n, part in ORDERS
        ]
    )
