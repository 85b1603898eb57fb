"""A force model near the depths of some readings, as power laws: cheap to solve with, and exact at the readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.model.force.force_model import ForceModel
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS

__all__ = ["LocalForces", "local_forces"]

Array = npt.NDArray[np.float64]

STEP = 1e-5  # m, over which a slope is taken
LEAST_DEPTH = 1e-4  # m; shallower readings are expanded about this


class LocalReading(Protocol):
    """A reading: stretch, height of the hand, and height of the top with its sd, m."""

    @property
    def stretch(self) -> float: ...
    @property
    def hand(self) -> float: ...
    @property
    def height(self) -> float: ...
    @property
    def sd(self) -> float: ...


@dataclass(frozen=True, slots=True)
class LocalForces:
    """Each reading's force, N, at its depth of the membrane, m, and the power with which it grows there: F (d / depth)^power."""

    depth: Array
    force: Array
    power: Array
    relative_sd: Array  # of the model, as a part of the force

    def at(self, depth: Array) -> tuple[Array, Array]:
        """Return the forces, N, at other depths (n,), m, near the readings' own, and their slopes, N/m; 0 above the membrane."""
        inside = np.maximum(depth, 1e-9)
        force = np.where(depth > 0, self.force * (inside / self.depth) ** self.power, 0.0)
        return force, force * self.power / inside


def local_forces(model: ForceModel, radius: float, readings: Sequence[LocalReading]) -> LocalForces:
    """Return the model's power laws about the readings.

    Raises
    ------
    IllConditioned
        The force does not grow with depth at a reading.
    InvalidInput
        A reading lies outside the model's range.
    """
    rows = []
    for reading in readings:
        depth = max(reading.height - reading.hand, LEAST_DEPTH)
        force, sd = model.predict(radius, reading.stretch, depth)
        deeper = min(depth + STEP, max(model.range.depth[1], depth))
        shallower = depth - STEP
        slope = model.predict(radius, reading.stretch, deeper)[0] - model.predict(radius, reading.stretch, shallower)[0]
        slope /= deeper - shallower
        if not (force > 0 and slope > 0):
            where = ", ".join(format_quantity(v, KINDS["Length"]) for v in (reading.stretch, depth))
            raise IllConditioned(
                f"the force model's force does not grow with depth at stretch and depth {where}, so it gives no drop"
            )
        rows.append((depth, force, slope * depth / force, sd / force))
    return LocalForces(*np.array(rows).T)
