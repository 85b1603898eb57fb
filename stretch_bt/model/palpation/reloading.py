"""Whether an object came back the way it went: readings under less force than an earlier press had, beside the curve of first loading."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.model.force.local import LocalReading, local_forces
from stretch_bt.model.palpation.balance import presses_of
from stretch_bt.model.palpation.law import MM
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    from stretch_bt.model.force.force_model import ForceModel
    from stretch_bt.model.palpation.series import Series

__all__ = ["left_behind", "of_first_loading", "reloads"]

R = TypeVar("R", bound=LocalReading)

CLEAR = 3.0  # standard deviations; a force that lies this far below an earlier one counts as less
LOST = 3.0  # standard deviations; a top that stands this much lower was left behind


def of_first_loading(
    readings: list[R],
    series: Series,
    fit: Callable[[list[R]], Series],
    model: ForceModel,
    radius: float,
    robot_sd: float,
    kind: Callable[[R], object] = type,
) -> tuple[list[R], Series]:
    """Return the readings of first loading and their curve by `fit` where the object did not come back as it went, else all readings.

    `series` is the curve of all; where too few are of first loading to have one of their own, it stays. Readings of another `kind` than
    the latest of first loading are not compared with it.

    Raises
    ------
    IllConditioned
        The object did not come back, and the latest reading is under less force than an earlier press.
    """
    most = reloads(model, radius, readings)
    first = [reading for reading, force in zip(readings, most, strict=True) if force == 0]
    alike = {kind(reading) for reading in first[-1:]}
    again = [reading for reading, force in zip(readings, most, strict=True) if force > 0 and kind(reading) in alike]
    if not again or (most[-1] > 0 and again[-1] is not readings[-1]):
        return readings, series
    try:
        loading = fit(first)
    except IllConditioned:
        return readings, series
    below = left_behind(loading, model, radius, again, robot_sd)
    if below.value <= LOST * below.sd:
        return readings, series
    if most[-1] > 0:
        raise IllConditioned(
            f"the object did not come back as it went: under less force than an earlier press its top stands {below.value * 1e3:.2f} mm"
            f" below the curve of first loading, with a standard deviation of {below.sd * 1e3:.2f} mm; press with more than {most[-1]:.2f} N"
        )
    return first, loading


def reloads(model: ForceModel, radius: float, readings: Sequence[LocalReading]) -> npt.NDArray[np.float64]:
    """Return the largest force of any earlier press, N, for each reading (n,) that is clearly below it, and 0 for the others.

    Raises
    ------
    IllConditioned
        The model's force does not grow with depth at a reading.
    InvalidInput
        A reading lies outside the model's range.
    """
    forces, press = local_forces(model, radius, readings), presses_of(readings)
    noise = forces.at(forces.depth)[1] * np.array([reading.sd for reading in readings])
    before = np.array([np.max(forces.force - noise, where=press < number, initial=0.0) for number in press])
    return np.where(forces.force + CLEAR * noise < before, before, 0.0)


def left_behind(
    loading: Series, model: ForceModel, radius: float, readings: Sequence[LocalReading], robot_sd: float
) -> Estimate:
    """Return by how much readings stand below the curve of first loading, m: the object settled, softened or slid there.

    The error of the curve and the hand's place count once for all readings; their own noise grows with the scatter about the curve.
    """
    forces = local_forces(model, radius, readings)
    curve = [loading.height_at(force) for force in forces.force]
    drop = np.array([loading.top.value - height.value for height in curve])
    power, growth = loading.power.value, loading.stiffening.value
    exponent = np.maximum(power + growth * drop / MM, 0.1 * power)  # of the force by the drop
    by_model = drop * forces.relative_sd / exponent
    own = np.array([reading.sd for reading in readings]) * max(loading.chi2, 1.0) ** 0.5
    weights = 1 / (own**2 + by_model**2)
    weights /= weights.sum()
    below = np.array([height.value - reading.height for height, reading in zip(curve, readings, strict=True)])
    shared = weights @ np.array([height.sd for height in curve])
    sd = np.sqrt(weights**2 @ own**2 + (weights @ by_model) ** 2 + shared**2 + robot_sd**2)
    return Estimate(float(weights @ below), float(sd))
