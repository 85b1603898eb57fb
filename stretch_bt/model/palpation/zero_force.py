"""The height of the object's undeformed top, from readings taken while it already gave way a little."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.units import Estimate

__all__ = ["undeformed_height"]


def undeformed_height(depths: npt.ArrayLike, heights: npt.ArrayLike, sds: npt.ArrayLike) -> Estimate:
    """Extrapolate the height of the object's top to zero force, m.

    A sphere meets a force that grows as depth^1.5 (Hertz), and an elastic object gives way in proportion to it, so
    height = h0 - c depth^1.5 with c at least 0, fitted by weighted least squares. The standard deviation is that of the
    fit with c free of its bound; where the bound holds, as for rigid objects, it is at most 1.4 times too large.

    Parameters
    ----------
    depths
        (n,) float, m: depth of the membrane at each reading (tracked height of the top minus height of the hand), all
        at one stretch.
    heights
        (n,) float, m, world: tracked height of the top at each reading.
    sds
        (n,) float, m: standard deviation of each height, above 0.

    Raises
    ------
    IllConditioned
        There are fewer than two different depths, so nothing can be extrapolated.
    """
    depth, height, sd = (np.atleast_1d(np.asarray(values, dtype=float)) for values in (depths, heights, sds))
    _check(depth, height, sd)
    basis = np.column_stack([np.ones_like(depth), -(depth**1.5)]) / sd[:, None]
    scale = np.linalg.norm(basis, axis=0)
    if not np.ptp(depth) > 1e-6 * depth.max():
        raise IllConditioned("the readings stand at one depth, so their height cannot be extrapolated to zero force")
    (h0, c), *_ = np.linalg.lstsq(basis / scale, height / sd)
    covariance = np.linalg.inv((basis / scale).T @ (basis / scale))
    value = h0 / scale[0] if c >= 0 else float(np.average(height, weights=sd**-2))
    return Estimate(float(value), math.sqrt(covariance[0, 0]) / float(scale[0]))


def _check(depth: npt.NDArray[np.float64], height: npt.NDArray[np.float64], sd: npt.NDArray[np.float64]) -> None:
    if depth.ndim != 1 or not depth.shape == height.shape == sd.shape:
        raise InvalidInput(f"depths, heights and sds must be (n,), got {depth.shape}, {height.shape} and {sd.shape}")
    if not all(np.all(np.isfinite(values)) for values in (depth, height, sd)):
        raise InvalidInput("depths, heights and sds must be finite, m")
    if np.any(depth < 0) or np.any(sd <= 0):
        raise InvalidInput("depths must be at least 0 m and sds above 0 m")
    if depth.size < 2:
        raise IllConditioned("one reading cannot be extrapolated to zero force; press at two depths or more")
