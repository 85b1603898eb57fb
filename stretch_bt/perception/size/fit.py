"""Least squares with a prior, for any hypothesis: Gauss-Newton with damping, step limits and mild robust weights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.robust import scale_of
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.correlation import correlation_area
from stretch_bt.perception.size.hypothesis import Hypothesis
from stretch_bt.perception.types import MaskArray

__all__ = ["Fit", "fit_to", "window_of"]

Array = npt.NDArray[np.float64]

INSIDE, OUTSIDE = 7e-3, 12e-3  # m around the rim that are fitted
REACH = 20e-3  # m from the centre, at least: a window that shrinks with the shape would settle on a bump of noise
FIRST_AREA = 12.0  # cells taken as one until the residuals show how many are: rather the prior than a wrong basin
FLOOR = 1e-5  # m, noise of a cell below which nothing is gained
STEPS = 25
DAMPING = 1e-5  # of the scaled normal equations, to begin with
STAGES = 5
SETTLED = 0.1  # share of the cells that may change when the rim moves
MET = 0.3, 1e-3  # square of the last step in standard deviations, before the noise is known and after
MOST_TAKEN = 0.6  # share of the independent cells that parameters may account for
FEWEST = 40  # cells


@dataclass(frozen=True, slots=True)
class Fit:
    """Parameters q (p,) and their covariance, and the cells that were fitted, in a window (rows, columns).

    `noise` is the standard deviation of one cell, m, and `area` the number of cells that count as one because their
    noise is correlated. `residuals` (rows, columns), m, are 0 outside the window.
    """

    q: Array
    covariance: Array
    window: MaskArray
    residuals: Array
    noise: float
    area: float
    steps: int


def window_of(shape: Hypothesis, q: Array, cells: HeightCells) -> MaskArray:
    """Return the cells around the rim of a shape that are to be fitted; raises IllConditioned where they are too few."""
    outside = shape.outside(q, cells.x.ravel(), cells.y.ravel()).reshape(cells.x.shape)
    radius = math.sqrt(np.count_nonzero(outside < 0.0) * cells.area / math.pi)
    window: MaskArray = cells.valid & (outside > -INSIDE) & (outside < max(OUTSIDE, REACH - radius))
    if np.count_nonzero(window) < FEWEST:
        raise IllConditioned(
            "too few valid pixels around the rim of the contact: where it ends is not seen; move the object to"
            " the middle of the membrane, and keep reflections off it"
        )
    return window


def fit_to(
    shape: Hypothesis, cells: HeightCells, q: Array, *, window: MaskArray | None = None, noise: float = 0.0
) -> Fit:
    """Fit a shape to cells from the parameters q.

    Parameters
    ----------
    window : (rows, columns) bool, or None
        Cells to fit; by default those around the rim, chosen anew as the rim moves.
    noise : float, m
        Standard deviation of a cell below which residuals say nothing.

    Raises
    ------
    IllConditioned
        Too few cells, or they leave a parameter free.
    """
    area, steps, informed = FIRST_AREA, 0, False
    chosen = window_of(shape, q, cells) if window is None else window
    for stage in range(STAGES):
        x, y, height = cells.x[chosen], cells.y[chosen], cells.height[chosen]
        q, information, residuals, sd, used = _refine(shape, x, y, height, q, area, max(noise, FLOOR), MET[informed])
        steps += used
        image = np.zeros(chosen.shape)
        image[chosen] = residuals
        moved = chosen if window is not None else window_of(shape, q, cells)
        settled = np.count_nonzero(moved ^ chosen) <= SETTLED * np.count_nonzero(chosen)
        if (settled and informed) or stage == STAGES - 1:
            break
        if settled:
            area, informed = correlation_area(image, chosen), True
        chosen = moved
    against = shape.prior(q)[1]
    by_cells = information - against @ against.T
    taken = float(np.trace(_inverse(information) @ by_cells)) * area / residuals.size
    share = 1.0 / (1.0 - min(taken, MOST_TAKEN))  # what the parameters took from the residuals
    return Fit(q, _inverse(by_cells / share + against @ against.T), chosen, image, sd, area * share, steps)


def _refine(
    shape: Hypothesis, x: Array, y: Array, height: Array, q: Array, area: float, floor: float, met: float
) -> tuple[Array, Array, Array, float, int]:
    """Return the best parameters, their information, the residuals, the noise of a cell and the steps that it took."""
    model, jacobian = shape.model(q, x, y)
    against, by_prior = shape.prior(q)
    residuals, damping = height - model, DAMPING
    sd, weights, cost = _weighed(residuals, against, area, floor)
    taken = 0
    for _ in range(STEPS):
        taken += 1
        weighted = jacobian * weights
        information = weighted @ jacobian.T + by_prior @ by_prior.T
        gradient = weighted @ residuals - by_prior @ against
        move = _solve(information, gradient, damping)
        move *= min(1.0, float((shape.scales(q) / np.maximum(np.abs(move), 1e-300)).min()))
        tried, new_jacobian = shape.model(q + move, x, y)
        new_against, new_by_prior = shape.prior(q + move)
        new_residuals = height - tried
        if weights @ new_residuals**2 + new_against @ new_against > cost * (1 + 1e-9):
            damping *= 10.0
            if damping > 1e6 or float(move @ information @ move) < 10.0 * met:
                break
            continue
        q, residuals, jacobian = q + move, new_residuals, new_jacobian
        against, by_prior = new_against, new_by_prior
        damping = max(0.1 * damping, 1e-8)
        small = float(move @ information @ move) < met
        sd, weights, cost = _weighed(residuals, against, area, floor)
        if small:
            break
    return q, (jacobian * weights) @ jacobian.T + by_prior @ by_prior.T, residuals, sd, taken


def _weighed(residuals: Array, against: Array, area: float, floor: float) -> tuple[float, Array, float]:
    """Return the noise of a cell, the weight of each, 1/m^2, and the sum that the fit lowers."""
    sd = max(scale_of(residuals), floor)
    weights = 1.0 / ((1.0 + 0.3 * (residuals / (3.0 * sd)) ** 2) * sd**2 * area)
    return sd, weights, float(weights @ residuals**2 + against @ against)


def _solve(information: Array, gradient: Array, damping: float) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    matrix = information * np.outer(scale, scale)
    matrix.flat[:: len(matrix) + 1] += damping
    try:
        return np.asarray(np.linalg.solve(matrix, gradient * scale) * scale)
    except np.linalg.LinAlgError:
        raise IllConditioned(
            "the cells around the contact leave its shape free: more than one shape explains them; press deeper, or name the shape (`hypothesis`)"
        ) from None


def _inverse(information: Array) -> Array:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
    if not values[0] > 1e-12:
        raise IllConditioned(
            "the cells around the contact leave its shape free: more than one shape explains them; press deeper, or name the shape (`hypothesis`)"
        )
    return np.asarray((vectors / values) @ vectors.T * np.outer(scale, scale))
