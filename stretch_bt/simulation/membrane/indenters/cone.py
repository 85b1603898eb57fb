"""A cone with a rounded tip."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing

__all__ = ["Cone"]


@dataclass(frozen=True, slots=True)
class Cone(Solid):
    """A cone whose surface makes `angle`, rad, with the membrane plane; `tip` is the radius of its tip, m."""

    angle: float
    tip: float = 0.5e-3

    def __post_init__(self) -> None:
        positive("the tip radius of a cone", self.tip)
        positive("the angle of a cone", self.angle, "rad")
        if self.angle >= math.pi / 2:
            raise InvalidInput(f"the angle of a cone must be below pi/2 rad, not {self.angle:g}")

    @property
    def feature(self) -> float:
        """Radius of the tip, m."""
        return self.tip

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, from the centre of the tip."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import cone

        gap = empty_gap(len(points))
        cone(points, self.angle, self.tip, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the tip radius, m; raises InvalidInput where the tilt lifts the flank above the tip."""
        if float(rotation[2, 2]) <= math.sin(math.pi / 2 - self.angle) + 1e-9:
            raise InvalidInput("a cone must tilt by less than its angle, or its flank is higher than its tip")
        return self.tip

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return the tip and a little beyond it."""
        size = spacing(self.tip, gauge)
        zone = [Zone(-4 * size, 4 * size, size)]
        return zone, zone
