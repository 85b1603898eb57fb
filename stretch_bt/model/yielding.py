"""How an object's top gives way under a growing force, from heights that were read at several presses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.units import Estimate

__all__ = ["Yielding", "fit_yielding"]

Array = npt.NDArray[np.float64]

POWER = (
    0.8,
    0.2,
)  # of force by which a drop grows, and its standard deviation: 1 for a spring, 0.63 for filled balloons
MODEL = 0.03  # of a drop, by which the ratio of forces at different stretches and depths is off
POWERS = np.linspace(0.3, 1.3, 101)


@dataclass(frozen=True, slots=True)
class Yielding:
    """The height of the undeformed `top`, the present `height` and the `drop` between them, m, and the `power`."""

    top: Estimate
    height: Estimate
    drop: Estimate
    power: float


def fit_yielding(forces: npt.ArrayLike, heights: npt.ArrayLike, sds: npt.ArrayLike) -> Yielding:
    """Fit height = top - drop (force / last force)^power to readings, and return what it says of the last one.

    The top at no force is never read, and every reading is noisy; the curve draws on all of them. The power is held by
    what objects do, 0.8 +- 0.2, and forces count as known to 3 %.
    Standard deviations are those of weighted least squares, times the root of the reduced chi
    squared where the readings scatter more than theirs allow.

    Parameters
    ----------
    forces
        (n,) float, N, above 0, of which at least two differ; the last one is that of the present press.
    heights, sds
        (n,) float, m: height of the top at each, and its standard deviation, above 0.

    Raises
    ------
    IllConditioned
        There are fewer than two readings, or all are at one force.
    """
    force, height, sd = (np.atleast_1d(np.asarray(values, dtype=float)) for values in (forces, heights, sds))
    _check(force, height, sd)
    share = force / force[-1]
    level = float(np.average(height, weights=sd**-2))
    # How far the curve goes at each reading says by how much the forces' own error moves it.
    _, q = _at_power(POWER[0], share, height - level, sd)
    sd = np.hypot(sd, MODEL * q[1] * share ** POWER[0])
    costs = [_at_power(p, share, height - level, sd)[0] for p in POWERS]
    cost, q = _at_power(float(POWERS[int(np.argmin(costs))]), share, height - level, sd)
    covariance = _covariance(q, share, sd) * max(1.0, cost / max(force.size - 2, 1))
    rows = {"top": [1.0, 0.0, 0.0], "height": [1.0, -1.0, 0.0], "drop": [0.0, 1.0, 0.0]}
    sd_of = {name: float(np.sqrt(np.array(row) @ covariance @ row)) for name, row in rows.items()}
    top, drop, power = (float(v) for v in q)
    return Yielding(
        Estimate(level + top, sd_of["top"]),
        Estimate(level + top - drop, sd_of["height"]),
        Estimate(drop, sd_of["drop"]),
        power,
    )


def _at_power(power: float, share: Array, height: Array, sd: Array) -> tuple[float, Array]:
    """Return the cost of the best top and drop at a power, with the power's own, and (top, drop, power)."""
    design = np.column_stack([np.ones_like(share), -(share**power)]) / sd[:, None]
    found, *_ = np.linalg.lstsq(design, height / sd)
    left = height / sd - design @ found
    return float(left @ left) + ((power - POWER[0]) / POWER[1]) ** 2, np.array([*found, power])


def _covariance(q: Array, share: Array, sd: Array) -> Array:
    """Return the covariance (3, 3) of top, drop and power."""
    grown = share ** q[2]
    rows = np.stack([np.ones_like(share), -grown, -q[1] * np.log(share) * grown]) / sd
    return np.asarray(np.linalg.inv(rows @ rows.T + np.diag([0.0, 0.0, POWER[1] ** -2])))


def _check(force: Array, height: Array, sd: Array) -> None:
    if force.ndim != 1 or not force.shape == height.shape == sd.shape:
        raise InvalidInput(f"forces, heights and sds must be (n,), got {force.shape}, {height.shape} and {sd.shape}")
    if not all(np.all(np.isfinite(values)) for values in (force, height, sd)):
        raise InvalidInput("forces, heights and sds must be finite, N and m")
    if np.any(force <= 0) or np.any(sd <= 0):
        raise InvalidInput("forces must be above 0 N and sds above 0 m")
    if force.size < 2 or np.ptp(force) <= 1e-3 * force.max():
        raise IllConditioned("readings at one force do not tell how far the object gives way; press at two or more")
