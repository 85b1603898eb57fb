"""What the fit of a shape hands on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stretch_bt.perception.types import FloatArray
from stretch_bt.units import Angle, Length

__all__ = ["DIMENSIONS", "KINDS", "Dimension", "Kind", "Solid", "Weighed", "pooled"]

Kind = Literal["block", "disc", "ridge", "half_cylinder", "domes", "point", "wire_circle", "wire_triangle", "extents"]
KINDS: tuple[Kind, ...] = (
    "block",
    "disc",
    "ridge",
    "half_cylinder",
    "domes",
    "point",
    "wire_circle",
    "wire_triangle",
    "extents",
)

#: what a shape may have, by name
DIMENSIONS = ("length", "width", "height", "radius", "side", "radius_1", "radius_2", "radius_3")


@dataclass(frozen=True, slots=True)
class Dimension:
    """A dimension and its standard deviation, m, and the change, m, that each step made to the value that was seen.

    `steps` has, by name, "membrane" for the change by the membrane's own roundness, and "table" for the change because
    the shape stands on the table. The value less all of them is the value that the surface shows.
    """

    value: Length
    sd: Length
    steps: Mapping[str, float]

    @property
    def seen(self) -> Length:
        """Value that the surface shows, m."""
        return self.value - sum(self.steps.values())


@dataclass(frozen=True, slots=True)
class Weighed:
    """A kind of shape with its evidence in nats, 0 for the best and None where it was not weighed, or why it was refused."""

    kind: Kind
    evidence: float | None
    refused: str = ""


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape on the table: its kind, its dimensions by name, where it stands and how it is turned.

    `x`, `y`, `z`, m, world, are the place of the middle of its top; `heading`, rad, the direction of its length from the world's x, in
    [-pi/2, pi/2), for a triangle the normal of a side, in [-pi/3, pi/3). `ranking` has all kinds that were compared, the best first.
    """

    kind: Kind
    dimensions: Mapping[str, Dimension]
    x: Length  # place of the middle of its top along x, world
    y: Length  # place of the middle of its top along y, world
    z: Length  # height of the middle of its top, world
    heading: Angle
    ranking: tuple[Weighed, ...]

    @property
    def middle(self) -> FloatArray:
        """The middle (3,), m, of its top, world."""
        return np.array([self.x, self.y, self.z])

    @property
    def length(self) -> Length | None:
        """The longer side of the top, or the length of a crest."""
        return self._value("length")

    @property
    def length_sd(self) -> Length | None:
        """Standard deviation of length."""
        return self._sd("length")

    @property
    def width(self) -> Length | None:
        """The shorter side of the top."""
        return self._value("width")

    @property
    def width_sd(self) -> Length | None:
        """Standard deviation of width."""
        return self._sd("width")

    @property
    def height(self) -> Length | None:
        """Height of the top above the table."""
        return self._value("height")

    @property
    def height_sd(self) -> Length | None:
        """Standard deviation of height."""
        return self._sd("height")

    @property
    def radius(self) -> Length | None:
        """Radius of a disc, half-cylinder, circle of wire or the largest dome."""
        return self._value("radius")

    @property
    def radius_sd(self) -> Length | None:
        """Standard deviation of radius."""
        return self._sd("radius")

    @property
    def side(self) -> Length | None:
        """Side of a triangle of wire, along its middle."""
        return self._value("side")

    @property
    def side_sd(self) -> Length | None:
        """Standard deviation of side."""
        return self._sd("side")

    @property
    def radius_1(self) -> Length | None:
        """Radius of the largest dome."""
        return self._value("radius_1")

    @property
    def radius_1_sd(self) -> Length | None:
        """Standard deviation of radius_1."""
        return self._sd("radius_1")

    @property
    def radius_2(self) -> Length | None:
        """Radius of the second dome."""
        return self._value("radius_2")

    @property
    def radius_2_sd(self) -> Length | None:
        """Standard deviation of radius_2."""
        return self._sd("radius_2")

    @property
    def radius_3(self) -> Length | None:
        """Radius of the third dome."""
        return self._value("radius_3")

    @property
    def radius_3_sd(self) -> Length | None:
        """Standard deviation of radius_3."""
        return self._sd("radius_3")

    def _value(self, name: str) -> Length | None:
        known = self.dimensions.get(name)
        return None if known is None else known.value

    def _sd(self, name: str) -> Length | None:
        known = self.dimensions.get(name)
        return None if known is None else known.sd


def pooled(found: list[Dimension], shared: float = 0.0) -> Dimension:
    """Return the mean of one dimension from several places, by 1 / sd^2; `shared`, m, is a standard deviation that all have in common.

    Where they differ by more than they say, the standard deviation of the mean grows by as much (Birge, 1932).
    """
    weights = [d.sd**-2 for d in found]
    total = sum(weights)
    value = sum(w * d.value for w, d in zip(weights, found, strict=True)) / total
    spread = sum(w * (d.value - value) ** 2 for w, d in zip(weights, found, strict=True))
    wider = max(1.0, spread / max(len(found) - 1, 1))
    steps = {
        name: sum(w * d.steps.get(name, 0.0) for w, d in zip(weights, found, strict=True)) / total
        for name in dict.fromkeys(name for d in found for name in d.steps)
    }
    return Dimension(value, float((wider / total + shared**2) ** 0.5), steps)
