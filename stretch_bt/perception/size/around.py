"""The skirt around any closed curve whose outside is mapped from the outside of the unit disc.

With log z = tau + i psi, sinh(n tau) cos(n psi) and its like are harmonic in the plane with y over k = sqrt(T_j / T_i), and
vanish on the rim, tau = 0; tau^2 times cos(n psi) stands for tensions that change from place to place.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.exterior import ExteriorMap

__all__ = ["COUNT", "ORDERS", "skirt_around", "slope_sums"]

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

KINK = 0.6e-3  # m, half the width over which the rim is rounded by its fillet and by the cells

# (harmonic or not, order n, cosine or sine)
ORDERS = tuple(
    (kind, n, part)
    for kind, most in (("sinh", 4), ("square", 2))
    for n in range(most + 1)
    for part in "cs"
    if n or part == "c"
)
COUNT = len(ORDERS)


def skirt_around(
    outline: ExteriorMap,
    by_size: Complex,
    k: float,
    coefficients: Array,
    x: Array,
    y: Array,
    sign: Array,
    least: float = 1.0,
) -> tuple[Array, Array, Array]:
    """Return how far the skirt falls below the face (n,), its derivatives (3 + shape, n), and its functions (COUNT, n).

    Parameters
    ----------
    by_size : (1 + shape, 1 + terms)
        Derivatives of C and the series of the outline by k and by the shape's own parameters.
    coefficients : (COUNT,), m
    x, y : (n,), m
        Places about the outline's centre.
    sign : (n,)
        1 outside; -1 where a place inside was mirrored into the outside; 0 where it is too far inside to matter.
    least : float
        Least |z|: below 1 where the map goes on inside the outline.

    The derivatives are by x and y of the centre, by k, and by the shape's own parameters.
    """
    from stretch_bt.perception.size.around_kernel import fill_skirt

    fall, by_rim, basis = np.empty(x.size), np.empty((2 + len(by_size), x.size)), np.empty((COUNT, x.size))
    c, x, y, sign = (np.ascontiguousarray(values, dtype=np.float64) for values in (coefficients, x, y, sign))
    fill_skirt(
        outline.scale, outline.series, outline.stride, by_size, k, least, KINK, c, x, y, sign, fall, by_rim, basis
    )
    return fall, by_rim, basis


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
