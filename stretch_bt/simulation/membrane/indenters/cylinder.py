"""A flat-ended cylinder with a rounded rim."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing

__all__ = ["Cylinder"]


@dataclass(frozen=True, slots=True)
class Cylinder(Solid):
    """A flat-ended cylinder of `diameter`, m, with a rim fillet, m; the origin lies one fillet below its face."""

    diameter: float
    rim: float = 1e-3

    def __post_init__(self) -> None:
        positive("the diameter of a cylinder", self.diameter)
        positive("the rim fillet of a cylinder", self.rim)
        if self.rim > self.diameter / 2:
            raise InvalidInput(
                f"the rim fillet must be at most the radius, {self.diameter / 2:g} m, not {self.rim:g} m"
            )

    @property
    def feature(self) -> float:
        """Radius of the fillet, m."""
        return self.rim

    @property
    def tip_radius(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    @property
    def flat(self) -> float:
        """Radius of its face, m."""
        return self.diameter / 2 - self.rim

    @property
    def post(self) -> bool:
        """True, also where its edge leaves no face."""
        return True

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import shaft

        gap = empty_gap(len(points))
        shaft(points, self.diameter / 2 - self.rim, self.rim, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of the raised rim above the origin, m."""
        lean = math.sqrt(max(1 - float(rotation[2, 2]) ** 2, 0.0))
        return self.rim + (self.diameter / 2 - self.rim) * lean

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return the face and a little beyond it."""
        size = min(spacing(self.diameter / 2, gauge), 4 * spacing(self.rim, gauge))
        reach = self.diameter / 2 + size
        return [Zone(-reach, reach, size)], [Zone(-reach, reach, size)]
