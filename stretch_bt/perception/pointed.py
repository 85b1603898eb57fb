"""Whether a top is round or a tip, and how far a tip stands above the vertex of the quadratic through it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.perhaps import odds_about, weighed
from stretch_bt.perception.robust import TUKEY
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    from stretch_bt.perception.top import Points

__all__ = ["FAINT_SHARPNESS", "TIPS", "of_tip", "tip_above", "tip_odds"]

Array = npt.NDArray[np.float64]

# height of a tip above the vertex of the quadratic through it, as a share of how far that falls within its disc: 0.33 of a cone, less of a
# blunt one, more where the disc holds skirt
SHARPNESS = Estimate(0.25, 0.2)
# the same where the fall is lost in the noise: 0 for caps, 0.1 for balls, 0.4 for cones, and 0.6 for tips, since noise makes their contact so wide
# that it holds skirt
FAINT_SHARPNESS = Estimate(0.5, 0.3)
TIPS = 1.0  # how many tips are pressed for each round top: with half as many, cones under shared noise were off by 1.4 stated deviations
LEAST_FALL = 1e-9  # m


def tip_above(design: Array, q: Array, left: Array, sd: float, vertex: Array, points: Points) -> Estimate:
    """Return the height, m, of a tip above a quadratic's vertex, by its residuals `left` (n,), m; below 0 for a face.

    `design` (6, n), or (4, n) with one curvature for all directions, and `q` (6,) are the quadratic's, `sd` the standard deviation of one
    residual, m, `vertex` (2,) the place of the vertex in the units of `design`. A tip is a cone with the quadratic's ellipses.
    """
    kx, kxy, ky = q[3:]
    x, y = design[1] - vertex[0], design[2] - vertex[1]
    cone = np.sqrt(np.maximum(kx * x * x + 2.0 * kxy * x * y + ky * y * y, 0.0))
    along = np.linalg.solve(design @ design.T, design @ cone)
    beside = cone - along @ design
    power = float(beside @ beside)
    if power <= 0.0:
        return Estimate(0.0, 0.0)  # of a surface that is not convex
    slope = float(beside @ np.clip(left, -TUKEY * sd, TUKEY * sd)) / power
    slope_sd = math.sqrt(sd * sd / power + float(points.shared(beside[None])[0, 0]) / power**2)
    u, v = vertex
    bent = [-0.5 * (u * u + v * v)] if len(design) == 4 else [-0.5 * u * u, -u * v, -0.5 * v * v]
    above = float(along @ np.array([1.0, u, v, *bent]))  # m, of a cone that falls by one
    return Estimate(-slope * above, math.hypot(slope_sd * above, points.step_error(sd)))  # terraces look like tips


def tip_odds(tip: Estimate, fall: float, before: float, sharpness: Estimate = SHARPNESS) -> float:
    """Return how many times likelier a top is a tip than round, by the tip, m, that a disc shows, the disc's fall, m, and the odds before."""
    return before * odds_about(tip, _usual(fall, sharpness))


def of_tip(tip: Estimate, fall: float, sharpness: Estimate = SHARPNESS) -> Estimate:
    """Return how far a tip stands above the vertex, m, where the top is one; `tip` and `fall` as in `tip_odds`."""
    return weighed(tip, _usual(fall, sharpness))


def _usual(fall: float, sharpness: Estimate) -> Estimate:
    fall = max(fall, LEAST_FALL)
    return Estimate(sharpness.value * fall, sharpness.sd * fall)
