"""How far the outline of a contact is from the fitted shape's, as the residuals around the rim show it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.fit import Fit
from stretch_bt.perception.size.hypothesis import Hypothesis

__all__ = ["Misfit", "misfit_of"]

Array = npt.NDArray[np.float64]

HARMONICS = np.arange(2, 11)  # of the outline around its middle
#: m, error of each of them in noise-free presses of cylinders and boxes, odd ones beside the middle (`python -m benchmarks.outline_kinds`)
MISSED = np.array([0.2, 0.2, 0.15, 0.12, 0.08, 0.08, 0.08, 0.08, 0.08]) * 1e-3
WIDTH = 0.15  # of the radius: standard deviation of each harmonic of any outline, over its number
STEP = 1e-4  # m over which slopes are taken
REACH = 1.5e-3  # m inside the rim, from where a moved rim shows
RATIOS = (-0.5, 5.0)


@dataclass(frozen=True, slots=True)
class Misfit:
    """The clearest harmonic of an outline about its shape: how far it may stand off, m, chi2 of 2 degrees of freedom, and its number."""

    off: float
    chi2: float
    harmonic: int


def misfit_of(shape: Hypothesis, fit: Fit, cells: HeightCells) -> Misfit:
    """Return how far an outline differs from its shape, by one more step of the fit with harmonics of the outline.

    A rim that stands farther out by a share cos(n t) lifts the membrane by that share of its slope there, and beyond the rim by a share
    that falls off as in any membrane in tension: as r^-n, in the coordinates in which the tensions are alike and the rim is a circle.
    """
    x, y, residuals = cells.x[fit.window], cells.y[fit.window], fit.residuals[fit.window]
    basis = _moved(shape, fit, x, y)
    _, jacobian = shape.model(fit.q, x, y)
    _, against = shape.prior(fit.q)
    weights = 1.0 / ((1.0 + 0.3 * (residuals / (3.0 * fit.noise)) ** 2) * fit.noise**2 * fit.area)
    own = (jacobian * weights) @ jacobian.T + against @ against.T
    own += 1e-12 * np.diag(np.diag(own))
    cross, theirs = (jacobian * weights) @ basis.T, (basis * weights) @ basis.T
    size = shape.measure(fit.q, fit.covariance)
    radius = 0.5 * math.sqrt(size.diameter_i[0] * size.diameter_j[0])
    theirs += np.diag((np.repeat(HARMONICS, 2) / (WIDTH * radius)) ** 2)
    mixed = np.linalg.solve(own, cross)
    covariance: Array = np.asarray(np.linalg.inv(theirs - cross.T @ mixed), dtype=np.float64)
    found = covariance @ (basis @ (weights * residuals) - mixed.T @ (jacobian @ (weights * residuals)))
    each = [_chi2(found[k : k + 2], covariance[k : k + 2, k : k + 2], MISSED[k // 2]) for k in range(0, len(found), 2)]
    clearest = int(np.argmax(each))
    pair = slice(2 * clearest, 2 * clearest + 2)
    off = math.sqrt(float(found[pair] @ found[pair] + np.trace(covariance[pair, pair]) / 2))
    return Misfit(off, each[clearest], int(HARMONICS[clearest]))


def _chi2(pair: Array, covariance: Array, missed: float) -> float:
    return float(pair @ np.linalg.solve(covariance + missed**2 * np.eye(2), pair))


def _waves(angles: Array) -> Array:
    """Return the harmonics (2 harmonics, n) at angles (n,)."""
    turns = HARMONICS[:, None] * angles
    return np.stack([np.cos(turns), np.sin(turns)], axis=1).reshape(2 * len(HARMONICS), -1)


def _moved(shape: Hypothesis, fit: Fit, x: Array, y: Array) -> Array:
    """Return the derivatives of heights (n,) by each harmonic of the outline, (2 harmonics, n), m / m."""
    size = shape.measure(fit.q, fit.covariance)
    dx, dy = x - size.center[0][0], y - size.center[1][0]
    away = np.maximum(np.hypot(dx, dy), 1e-9)
    along = STEP * dx / away, STEP * dy / away
    inner, outer = (shape.model(fit.q, x + s * along[0], y + s * along[1])[0] for s in (-0.5, 0.5))
    slope = np.where(shape.outside(fit.q, x, y) > -REACH, np.maximum(inner - outer, 0.0) / STEP, 0.0)
    k = math.exp(0.5 * float(np.clip(fit.q[shape.ratio], *RATIOS)))
    zeta = _circled(dx, dy / k, size.diameter_i[0] / 2, size.diameter_j[0] / 2 / k)
    fall = np.maximum(np.abs(zeta), 1.0)[None] ** -np.repeat(HARMONICS, 2)[:, None]
    return np.asarray(_waves(np.angle(zeta)) * fall * slope)


def _circled(x: Array, y: Array, a: float, b: float) -> npt.NDArray[np.complex128]:
    """Return places (n,) by the map that takes the outside of an ellipse of half axes a and b to the outside of the unit circle."""
    w, m = (x + 1j * y) / ((a + b) / 2), (a - b) / (a + b)
    root = np.sqrt(w * w - 4 * m + 0j)
    first, second = (w + root) / 2, (w - root) / 2
    return np.asarray(np.where(np.abs(first) >= np.abs(second), first, second))
