"""Forces that were measured on hemispheres, as calibrations take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.calibration.characterization import Table
from stretch_bt.model.calibration.conditioning import Conditioning
from stretch_bt.model.force.force_model import ForceModel, Range

__all__ = ["Measurements", "forces"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STUCK = 1e-9
_FEWEST = 3
# m: the step of a coarse gripper, which is less than what a protocol steps by, and how far a gripper stands off either way together
_STEP, _SAME = 6.5e-4, 1.3e-3
_DIGITS = 9
_ROUNDING = 1e-9  # m


@dataclass(frozen=True)
class Measurements:
    """Arrays (n,), m and N: the sphere's radius, the stretch, the depth past first contact, the force and its standard deviation.

    `conditioned` is how the membrane was softened before, None where that is not known.
    """

    radius: Array
    stretch: Array
    depth: Array
    force: Array
    force_sd: Array
    conditioned: Conditioning | None = None

    def __post_init__(self) -> None:
        arrays = [self.radius, self.stretch, self.depth, self.force, self.force_sd]
        if any(a.ndim != 1 or a.shape != self.radius.shape for a in arrays):
            raise InvalidInput(f"measurements must be arrays (n,) of one length, got {[a.shape for a in arrays]}")
        if not all(np.isfinite(a).all() for a in arrays):
            raise InvalidInput("measurements must be finite, m and N")
        if (self.radius <= 0).any() or (self.stretch < 0).any() or (self.depth < 0).any() or (self.force_sd < 0).any():
            raise InvalidInput("a radius must be above 0 m; stretch, depth and standard deviation at least 0")

    @classmethod
    def of(cls, table: Table) -> Measurements:
        """Return the presses of hemispheres of a table, where a depth above first contact is 0.

        Stretches that steps of at most 0.65 mm join, 1.3 mm in all, are one: their mean.
        """
        ball = table.geometry == "sphere"
        if not ball.any():
            raise IllConditioned("the table holds no press of a hemisphere, which is what force models are fitted to")
        columns = (np.round(table.size, _DIGITS) / 2, table.stretch, table.depth, table.force, table.force_sd)
        radius, stretch, depth, force, sd = (column[ball] for column in columns)
        stretch, depth = np.maximum(_together(stretch), 0.0), np.maximum(depth, 0.0)
        return cls(radius, stretch, depth, force, sd, Conditioning.of(table.provenance))

    def __len__(self) -> int:
        return len(self.radius)

    def where(self, kept: Mask) -> Measurements:
        """Return those where a mask (n,) is true."""
        radius, stretch, depth, force, sd = (
            column[kept] for column in (self.radius, self.stretch, self.depth, self.force, self.force_sd)
        )
        return Measurements(radius, stretch, depth, force, sd, self.conditioned)

    @property
    def diameters(self) -> list[float]:
        """The different diameters, m, rising."""
        return [float(d) for d in np.unique(np.round(2 * self.radius, _DIGITS))]

    def of_diameter(self, diameter: float) -> Mask:
        """Return a mask (n,) of one diameter, m."""
        found: Mask = np.isclose(2 * self.radius, diameter, rtol=1e-6)
        return found

    @property
    def range(self) -> Range:
        """The measured range of radius, stretch and depth, from no depth on."""
        return Range(
            (float(self.radius.min()), float(self.radius.max())),
            (float(self.stretch.min()), float(self.stretch.max())),
            (0.0, float(self.depth.max())),
        )

    def check(self) -> None:
        """Raise IllConditioned where nothing can be fitted: too few presses, or a force that does not answer to depth."""
        pressed = self.depth > 0
        if int(pressed.sum()) < _FEWEST:
            raise IllConditioned(
                f"{int(pressed.sum())} presses are too few to calibrate with; at least {_FEWEST} are needed"
            )
        if np.ptp(self.force) <= _STUCK:
            raise IllConditioned("all forces are the same, as from a stuck sensor; check the force sensor")
        depth, force = self.depth - self.depth.mean(), self.force - self.force.mean()
        if float(depth @ force) <= 0 and np.ptp(self.depth) > 0:
            raise IllConditioned("the force does not grow with depth; check the sign and the zero of the force sensor")


def forces(model: ForceModel, given: Measurements) -> Array:
    """Return (n,) float, N: the model's force at each press, and for a press too deep for it the force at its deepest."""
    rows = zip(given.radius, given.stretch, given.depth, strict=True)
    return np.array([model.predict(r, x, min(d, model.deepest(r, x)))[0] for r, x, d in rows])


def _together(values: Array) -> Array:
    """Return values, m, where those that a gripper's step joins, 1.3 mm at most, are replaced by their mean: where it stood."""
    order = np.argsort(values)
    group, first, last = np.zeros(len(values), int), values[order[0]], values[order[0]]
    for k, value in enumerate(values[order]):
        begins = value - last > _STEP or value - first > _SAME + _ROUNDING
        first, last = value if begins else first, value
        group[k] = group[max(k - 1, 0)] + begins
    means = np.bincount(group, values[order]) / np.bincount(group)
    found = np.empty_like(values)
    found[order] = np.round(means[group], _DIGITS)
    return found
