"""Whether an object came back the way it went: readings under less force than an earlier press had, beside the curve of first loading."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stretch_bt.model.force.local import Pressed, local_forces
from stretch_bt.model.palpation.balance import presses_of
from stretch_bt.units import Estimate

if TYPE_CHECKING:
    from stretch_bt.model.force.force_model import ForceModel
    from stretch_bt.model.palpation.series import Series

__all__ = ["left_behind", "reloads"]

CLEAR = 3.0  # standard deviations by which a force must lie below an earlier one to count as less


def reloads(model: ForceModel, radius: float, readings: Sequence[Pressed]) -> npt.NDArray[np.float64]:
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
    loading: Series, model: ForceModel, radius: float, readings: Sequence[Pressed], robot_sd: float
) -> Estimate:
    """Return by how much readings stand below the curve of first loading, m: what settled, softened or slid there.

    The error of the curve and the hand's place count once for all readings; their own noise grows with the scatter about the curve.
    """
    forces = local_forces(model, radius, readings)
    curve = [loading.height_at(force) for force in forces.force]
    by_model = np.array([loading.top.value - height.value for height in curve]) * forces.relative_sd
    own = np.array([reading.sd for reading in readings]) * max(loading.chi2, 1.0) ** 0.5
    weights = 1 / (own**2 + by_model**2)
    weights /= weights.sum()
    below = np.array([height.value - reading.height for height, reading in zip(curve, readings, strict=True)])
    shared = weights @ np.array([height.sd for height in curve])
    sd = np.sqrt(weights**2 @ own**2 + (weights @ by_model) ** 2 + shared**2 + robot_sd**2)
    return Estimate(float(weights @ below), float(sd))
