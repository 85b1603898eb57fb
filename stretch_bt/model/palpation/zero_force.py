"""The height of the object's undeformed top, from readings taken while it already gave way a little."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import as_reals
from stretch_bt.units import Estimate

__all__ = ["HERTZ", "drop_power", "undeformed_height"]

Array = npt.NDArray[np.float64]

#: power p of a linear object's drop ~ depth^p under a Hertzian membrane
HERTZ = Estimate(1.5, 0.0)
# Power p of the sheet's force ~ depth^p on spheres of 40 and 50 mm, between 2 and 6 mm, by the strain of the free sheet:
# `stretch-bt press --indenter sphere:50mm --stretch 14mm --depth 4mm`. A slack one has 3, a drum 1.
STRAINS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)
POWERS = (3.1, 1.8, 1.67, 1.54, 1.46, 1.4, 1.34, 1.29)


def drop_power(strain: Estimate, power: Estimate) -> Estimate:
    """Return the power p of an object's drop ~ depth^p under a membrane of a strain; the object's force is a `power` of its deflection.

    Raises InvalidInput where a number is not finite, a deviation is below 0 or the power is not above 0.
    """
    check_estimates(strain=strain, power=power)
    if power.value <= 0:
        raise InvalidInput(f"strain and power must be finite, and the power above 0, not {strain} and {power}")
    membrane, less = (float(np.interp(at, STRAINS, POWERS)) for at in (strain.value, strain.value - strain.sd))
    value = membrane / power.value
    return Estimate(value, value * math.hypot((less - membrane) / membrane, power.sd / power.value))


def undeformed_height(
    depths: npt.ArrayLike, heights: npt.ArrayLike, sds: npt.ArrayLike, *, power: Estimate = HERTZ
) -> Estimate:
    """Extrapolate the height of the object's top to zero force, m.

    The object gives way by a power of the membrane's depth, so height = h0 - c depth^power with c at least 0, fitted by weighted least
    squares. The standard deviation is from the fit with c free of its bound, with half of the height's change between the
    power less and plus its deviation; where the bound holds, as for rigid objects, it is at most 1.4 times too large.

    Parameters
    ----------
    depths
        (n,) float, m: depth of the membrane at each reading (tracked height of the top minus height of the hand), all
        at one stretch.
    heights
        (n,) float, m, world: tracked height of the top at each reading.
    sds
        (n,) float, m: standard deviation of each height, above 0.
    power
        Power of depth with which the object's drop grows, above its standard deviation; see `drop_power`.

    Raises
    ------
    IllConditioned
        There are fewer than two different depths, so nothing can be extrapolated.
    """
    given = {"depths": depths, "heights": heights, "sds": sds}
    depth, height, sd = (np.atleast_1d(as_reals(f"{name} must be", values, "m")) for name, values in given.items())
    check_estimates(power=power)
    _check(depth, height, sd)
    if not np.ptp(depth) > 1e-6 * depth.max():
        raise IllConditioned("the readings stand at one depth, so their height cannot be extrapolated to zero force")
    if not power.sd < power.value:
        raise InvalidInput(f"power must be finite and above its standard deviation, not {power}")
    found = _extrapolated(depth, height, sd, power.value)
    if not power.sd:
        return found
    ends = [_extrapolated(depth, height, sd, power.value + off).value for off in (-power.sd, power.sd)]
    return Estimate(found.value, math.hypot(found.sd, (ends[1] - ends[0]) / 2))


def _extrapolated(depth: Array, height: Array, sd: Array, power: float) -> Estimate:
    basis = np.column_stack([np.ones_like(depth), -((depth / depth.max()) ** power)]) / sd[:, None]
    scale = np.linalg.norm(basis, axis=0)
    (h0, c), *_ = np.linalg.lstsq(basis / scale, height / sd)
    try:
        covariance = np.linalg.inv((basis / scale).T @ (basis / scale))
    except np.linalg.LinAlgError:
        covariance = np.zeros((2, 2))
    if not covariance[0, 0] > 0:
        raise IllConditioned("the readings do not determine the height at no force; press at depths further apart")
    value = h0 / scale[0] if c >= 0 else float(np.average(height, weights=sd**-2))
    return Estimate(float(value), math.sqrt(covariance[0, 0]) / float(scale[0]))


def _check(depth: Array, height: Array, sd: Array) -> None:
    if depth.ndim != 1 or not depth.shape == height.shape == sd.shape:
        raise InvalidInput(f"depths, heights and sds must be (n,), got {depth.shape}, {height.shape} and {sd.shape}")
    if not all(np.all(np.isfinite(values)) for values in (depth, height, sd)):
        raise InvalidInput("depths, heights and sds must be finite, m")
    if np.any(depth < 0) or np.any(sd <= 0):
        raise InvalidInput("depths must be at least 0 m and sds above 0 m")
    if not depth.size:
        raise IllConditioned(
            "there is no reading of the top, so that no height can be found; press at two depths or more"
        )
    if depth.size < 2:
        raise IllConditioned("one reading cannot be extrapolated to zero force; press at two depths or more")
