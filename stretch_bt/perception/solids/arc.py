"""The arc of a round crest in a profile, and the membrane that leaves it on either side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.profile import HeightProfile

__all__ = ["Arc", "fit_arc"]

Array = npt.NDArray[np.float64]

FEWEST = 15
MODEL = 5e-6  # m
ALIKE = 8.0
SMALLEST, LARGEST = 0.3, 150.0  # mm
WIDEST = 0.9  # of its radius that an arc reaches to either side
STARTS = (5.0, 12.0, 25.0)  # mm


@dataclass(frozen=True, slots=True)
class Arc:
    """A circle of some radius, m, with its highest point at `place` and `height`, m, each with its standard deviation."""

    place: float
    place_sd: float
    height: float
    height_sd: float
    radius: float
    radius_sd: float
    rms: float


def fit_arc(profile: HeightProfile, start: float, *, reach: float, layer: tuple[float, float]) -> Arc:
    """Fit an arc near a place, m, to the part of a profile within `reach`, m.

    The membrane touches the arc over some width to each side and leaves it with the curvature of the arc, which decays
    over `layer`, m, the mean and the standard deviation of the square root of its bending stiffness over its tension.

    Raises
    ------
    IllConditioned
        Too little of the profile is seen.
    """
    from scipy.optimize import least_squares

    part = profile.between(start - reach, start + reach)
    if len(part.at) < FEWEST or part.at[0] > start - reach / 2 or part.at[-1] < start + reach / 2:
        raise IllConditioned("too little of the membrane is seen beside the crest; press nearer to it")
    scale = max(MODEL, profile.noise / 3)

    def left(q: Array) -> Array:
        return np.append(_linear(part, q)[1] / scale, (q[4] * 1e-3 - layer[0]) / layer[1])

    middle = start * 1e3
    low = [middle - 4, SMALLEST, 0.02, 0.02, 0.2]
    high = [middle + 4, LARGEST, 1e3 * reach, 1e3 * reach, 6.0]
    fits = [least_squares(left, [middle, r, 2.0, 2.0, layer[0] * 1e3], bounds=(low, high)) for r in STARTS]
    best = min(fits, key=lambda f: float(f.cost))
    fit, residual = _linear(part, best.x)
    rms = math.sqrt(float(np.mean(residual**2)))
    jacobian: Array = np.asarray(best.jac)
    wider = max(1.0, rms / scale) * math.sqrt(ALIKE)
    sd = 1e-3 * wider * np.sqrt(np.maximum(np.diag(np.linalg.pinv(jacobian.T @ jacobian)), 0.0))
    height_sd = max(rms, MODEL, profile.noise / math.sqrt(float(part.count.sum()) / ALIKE**2))
    return Arc(
        float(best.x[0]) * 1e-3, float(sd[0]), float(fit[0]), height_sd, float(best.x[1]) * 1e-3, float(sd[1]), rms
    )


def _linear(part: HeightProfile, q: Array) -> tuple[Array, Array]:
    """Return height and the skirts' curvatures, and the weighted residuals (n,), m; `q` is in mm."""
    place, radius, left, right, layer = q * 1e-3
    u = part.at - place
    shape = np.where(u < 0, _side(-u, radius, left, layer), _side(u, radius, right, layer))
    design = np.column_stack(
        [np.ones_like(u), np.maximum(-u - left, 0.0) ** 2 / 2, np.maximum(u - right, 0.0) ** 2 / 2]
    )
    weights = np.sqrt(part.count / part.count.mean())
    fit = np.linalg.lstsq(design * weights[:, None], (part.height - shape) * weights, rcond=None)[0]
    return fit, (shape + design @ fit - part.height) * weights


def _side(u: Array, radius: float, width: float, layer: float) -> Array:
    """Return the height under the top, m, of an arc up to `width`, and of the membrane that leaves it beyond."""
    width = min(width, WIDEST * radius)
    root = math.sqrt(radius**2 - width**2)
    slope, curvature = -width / root, -(radius**2) / root**3
    away = np.maximum(u - width, 0.0)
    on = np.sqrt(radius**2 - np.clip(u, 0.0, width) ** 2) - radius
    return np.asarray(on + slope * away + curvature * layer * (away - layer * (1 - np.exp(-away / layer))))
