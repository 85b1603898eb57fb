"""Whether the body that a sphere was fitted to may be something else: a lying cylinder, a face that leans, or a sheet that spans a face as a drum."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.contact_cells import Cells
from stretch_bt.perception.shapes.contact_fit import BodyFit
from stretch_bt.perception.shapes.contact_noise import NoiseParts, whitener
from stretch_bt.perception.shapes.pressed_surface import LIFT_AT

__all__ = ["check_ball"]

Array = npt.NDArray[np.float64]

INSIDE = 0.9  # of the rim, within which the body alone is seen
LEAST = 16  # fewest cells there, for a test of forms
# Set over balls, lying cylinders and leaning boxes under membranes of constant tensions, sharp and blurred over 1.2 mm, with four kinds of noise.
# Difference of two principal curvatures over their sum, with SURE deviations, from which a contact may be a ridge, where it is 1, and one that is
# clearly more than a ball's: of 165 balls 1 % are beyond one of them, and seven in ten of the others that had passed for balls.
RIDGE, SURE = 0.5, 2.0
UNEVEN, CERTAIN = 0.4, 3.3
# What is uneven for sure, as the top of an ellipsoid with axes as 5 to 4; and deviations below which noise may make a ball uneven.
CLEAR, CLEARLY = 0.12, 4.0
BY_NOISE = 2.5
# Most lift of a sheet of 2 mm around a ball, over the ball's curvature, m^2: D / T is 3e-6 to 7e-6, 520 balls came to 4.7e-6, and membranes over
# ellipsoids, which the rim of no ball fits, to 12e-6 and more, with a rim of less than 1.4 bending lengths. A wide rim is one, whatever is around it.
LIFTED, WIDE = 8e-6, 2.0
# Chi-square of seven other forms, and how much of them there is over the fall from top to rim, from which there are some: of 173 balls none is
# beyond both, and four in ten of the others that are left.
OTHER, SEEN = 30.0, 0.15


def check_ball(fit: BodyFit, cells: Cells, noise: NoiseParts, own: float) -> float:
    """Refuse a sphere whose contact may be a ridge, or whose residuals within the rim hold forms that no ball has.

    Returns the difference of its two principal curvatures over their sum, as far as noise does not explain it: the relative error of one
    curvature for both. `own` is the least error of a cell by itself, over the standard deviation of a pixel. The forms are the aberrations of
    an optical surface that is no sphere: astigmatism, which makes a ridge, then coma, trefoil, spherical and fourfold aberration.
    """
    q, rim = fit.surface.q, fit.surface.rim
    if rim < WIDE * abs(q[LIFT_AT + 1]) and q[LIFT_AT] * (q[LIFT_AT + 1] * cells.size) ** 2 > LIFTED:
        raise IllConditioned(
            "the membrane around the contact stands higher than bending lifts a sheet of 2 mm around a ball; the object may be an ellipsoid, or the"
            " sheet thicker: press deeper, average more frames, or fit another shape (`fit_shape`)"
        )
    inside = np.hypot((cells.x - q[6]) / math.exp(q[4]), (cells.y - q[7]) / math.exp(q[5])) < INSIDE
    if np.count_nonzero(inside) < LEAST:
        raise IllConditioned(
            "too little of the contact is seen to distinguish a ball from something else; press deeper"
        )
    x, y, seen = (cells.x[inside] - q[6]) / rim, (cells.y[inside] - q[7]) / rim, cells.some(inside)
    whiten = whitener(noise.own(seen, own), noise.shared(seen) if noise.smooth else None)
    square, ridge = x * x + y * y, [x * x - y * y, 2.0 * x * y]
    even = [np.ones_like(x), x, y, square]
    other = [square * x, square * y, x * (square - 4.0 * y * y), y * (4.0 * x * x - square), square**2]
    other += [ridge[0] ** 2 - ridge[1] ** 2, ridge[0] * ridge[1]]
    fall = 0.5 * abs(float(q[3])) * rim**2
    whitened = whiten(np.stack([*other, *ridge, *even, fit.residuals[inside]], axis=1))
    found, covariance = _held(whitened[:, len(other) :], len(ridge))
    there, sd = float(np.linalg.norm(found)) / fall, math.sqrt(float(np.trace(covariance)) / len(ridge)) / fall
    if there + SURE * sd > RIDGE or there > max(UNEVEN, CERTAIN * sd) or there > max(CLEAR, CLEARLY * sd):
        raise IllConditioned(
            f"the contact may be no ball: its two curvatures differ by {there:.2f} +- {sd:.2f} of their sum, and a ball's do not; the"
            " object may be an ellipsoid, a lying cylinder, or a face that leans: press deeper, average more frames, or fit another shape"
            " (`fit_shape`)"
        )
    found, covariance = _held(whitened, len(other))
    if float(found @ np.linalg.pinv(covariance) @ found) > OTHER and float(np.linalg.norm(found)) > SEEN * fall:
        raise IllConditioned(
            "the contact is no ball: it is rounder at one side or at its rim than at its top, as a membrane is that spans a face; measure a flat"
            " face (`measure_contact`), or fit another shape (`fit_shape`)"
        )
    return math.sqrt(max(there**2 - (BY_NOISE * sd) ** 2, 0.0))


def _held(whitened: Array, count: int) -> tuple[Array, Array]:
    """Return how much of the first columns (count,) there is in the last one, and the covariance of that."""
    design, left = whitened[:, :-1], whitened[:, -1]
    covariance = np.asarray(np.linalg.pinv(design.T @ design), dtype=np.float64)
    return (covariance @ (design.T @ left))[:count], covariance[:count, :count]
