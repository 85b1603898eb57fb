"""Where a membrane bends over an edge, a ridge or a wire: the meeting point of its straight parts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.profile import HeightProfile

__all__ = ["CONVERGED", "Bend", "fit_bend", "search_bend"]

Array = npt.NDArray[np.float64]

SHORTEST, LONGEST = 0.1e-3, 6e-3  # m over which a membrane bends
FEWEST = 12  # places of a profile
BESIDE = 4e-3  # m that must be seen on either side of a bend
MODEL = 5e-6  # m, least difference of a membrane's profile from a bend
ALIKE = 8.0  # neighbouring places of a profile that err as one
STEEPEST, LEAST = 3.0, 0.04  # change of slope
REACH = 12e-3  # m on either side of a bend to which it is fitted
STARTS = 1.5e-3  # m between places at which the search begins
#: so near to the best fit that the answer does not depend on how a processor rounds
CONVERGED: Any = {"ftol": 1e-14, "xtol": 1e-10, "gtol": 1e-10}


@dataclass(frozen=True, slots=True)
class Bend:
    """A bend of a profile: straight on its near side, straight but for a steady curvature on its far one.

    `place`, m, is where the straight parts meet, `height`, m, is this point's height; `near` and `far` are their slopes and
    `length`, m, is the length over which the membrane passes from one to the other: its slope changes as 1 - exp(-|u| / length).
    """

    place: float
    sd: float
    height: float
    height_sd: float
    near: float
    far: float
    length: float
    length_sd: float
    rms: float

    @property
    def change(self) -> float:
        """Fall of the slope."""
        return self.near - self.far

    @property
    def surface(self) -> float:
        """Height of the membrane itself at the place, m, which the straight parts pass above."""
        return self.height - self.change * self.length / 2

    @property
    def radius(self) -> float:
        """Radius of curvature of the membrane at the place, m."""
        return 2 * self.length / max(self.change, 1e-9)


def search_bend(profile: HeightProfile, low: float, high: float) -> Bend:
    """Return the bend of a profile that explains it best, between two places, m.

    Raises
    ------
    IllConditioned
        There is none.
    """
    found = []
    for start in np.arange(low, high, STARTS):
        try:
            found.append(_cost(profile, float(start), 1e-3))
        except IllConditioned:
            continue
    if not found:
        raise IllConditioned("the profile shows no bend: no edge is seen; press nearer to an edge")
    begin = min(found)[1]
    return fit_bend(profile, begin)


def _cost(profile: HeightProfile, place: float, length: float) -> tuple[float, float]:
    """Return how badly a bend at a place explains the whole profile, and the place; a profile that does not bend down has none."""
    part = profile.between(place - REACH, place + REACH)
    _check(part, place)
    fit, left = _linear(part, place, length)
    if not LEAST < fit[2] < STEEPEST:
        raise IllConditioned("no bend")
    # windows differ, so that the change of slope, surely known, decides
    return float(np.mean(left**2)) / fit[2] ** 2, place


def fit_bend(profile: HeightProfile, start: float, *, reach: float = REACH, curved: bool = False) -> Bend:
    """Fit a bend near a place, m, to the part of a profile within `reach`, m, of it; its near side may be `curved` like its far one.

    Raises
    ------
    IllConditioned
        Too little of the profile is seen on one side, or it does not bend down.
    """
    from scipy.optimize import least_squares

    part = profile.between(start - reach, start + reach)
    _check(part, start)

    def left(q: Array) -> Array:
        return _linear(part, q[0] * 1e-3, q[1] * 1e-3, curved)[1] * 1e3

    def slopes(q: Array) -> Array:
        return _slopes(part, q[0] * 1e-3, q[1] * 1e-3, curved)

    slack = min(6.0, reach * 0.6e3)
    bounds = ([start * 1e3 - slack, SHORTEST * 1e3], [start * 1e3 + slack, LONGEST * 1e3])
    found = least_squares(left, [start * 1e3, 1.0], bounds=bounds, jac=slopes, **CONVERGED)
    place, length = (float(v) * 1e-3 for v in found.x)
    _check(part, place)
    fit, residual = _linear(part, place, length, curved)
    change = float(fit[2])
    if not LEAST < change < STEEPEST:
        raise IllConditioned("the profile does not bend down there: no edge is seen; press nearer to an edge")
    rms = math.sqrt(float(np.mean(residual**2)))
    # A place errs by the error that neighbours share: the residuals of a profile are smooth.
    noise = max(rms * math.sqrt(ALIKE), MODEL, part.noise / math.sqrt(float(part.count.mean())) * math.sqrt(ALIKE))
    jacobian: Array = np.asarray(found.jac)
    covariance = noise**2 * np.linalg.pinv(jacobian.T @ jacobian)
    return Bend(
        place,
        math.sqrt(float(covariance[0, 0])),
        float(fit[0]),
        noise,
        float(fit[1]),
        float(fit[1] - change),
        length,
        math.sqrt(float(covariance[1, 1])),
        rms,
    )


def _check(part: HeightProfile, place: float) -> None:
    if len(part.at) < FEWEST or part.at[0] > place - BESIDE or part.at[-1] < place + BESIDE:
        raise IllConditioned(
            "too little of the membrane is seen on one side of the bend; press so that the edge lies nearer to the middle of the membrane"
        )


def _linear(part: HeightProfile, place: float, length: float, curved: bool = False) -> tuple[Array, Array]:
    """Return height, slope, its change, the far and perhaps the near curvature of a bend, and the weighted residuals (n,), m."""
    design, weights = _design(part, place, length, curved)
    fit = np.asarray(np.linalg.lstsq(design, part.height * weights, rcond=None)[0], dtype=np.float64)
    return fit, design @ fit - part.height * weights


def _design(part: HeightProfile, place: float, length: float, curved: bool) -> tuple[Array, Array]:
    """Return (n, k): the weighted heights that each number of a bend adds, and the weights (n,)."""
    u = part.at - place
    beyond = np.maximum(u, 0.0)
    turn = beyond + length / 2 * np.exp(-np.abs(u) / length)
    near = [np.minimum(u, 0.0) ** 2 / 2] if curved else []
    weights: Array = np.sqrt(part.count / part.count.mean())
    return np.column_stack([np.ones_like(u), u, -turn, beyond * beyond / 2, *near]) * weights[:, None], weights


def _slopes(part: HeightProfile, place: float, length: float, curved: bool) -> Array:
    """Return (n, 2): how the weighted residuals change with place and length while the other numbers fit (Golub and Pereyra, 1973)."""
    design, weights = _design(part, place, length, curved)
    u = part.at - place
    decay = np.exp(-np.abs(u) / length) / 2
    side = np.heaviside(u, 0.5)
    near = [-np.minimum(u, 0.0)] if curved else []
    moved = np.column_stack([0.0 * u, 0.0 * u - 1.0, side - np.sign(u) * decay, -np.maximum(u, 0.0), *near])
    longer = np.zeros_like(moved)
    longer[:, 2] = -decay * (1.0 + np.abs(u) / length)
    inverse = np.linalg.pinv(design)
    fit = inverse @ (part.height * weights)
    left = design @ fit - part.height * weights
    columns = []
    for change in (moved, longer):
        change *= weights[:, None]
        direct = change @ fit
        columns.append(direct - design @ (inverse @ direct) - inverse.T @ (change.T @ left))
    return np.column_stack(columns)
