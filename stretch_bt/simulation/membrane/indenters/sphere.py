"""A hemisphere on a shank of its own diameter."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing

__all__ = ["Sphere", "goes_on_as"]


@dataclass(frozen=True, slots=True)
class Sphere(Solid):
    """A hemisphere of `diameter`, m, on a shank; the origin is its centre."""

    diameter: float

    def __post_init__(self) -> None:
        positive("the diameter of a sphere", self.diameter)

    @property
    def feature(self) -> float:
        """Its radius, m."""
        return self.diameter / 2

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import shaft

        gap = empty_gap(len(points))
        shaft(points, 0.0, self.diameter / 2, *gap)
        return gap

    def top(self, rotation: Array) -> float:
        """Return its radius, m: a tilt turns it about its centre."""
        return self.diameter / 2

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return three elements on either side of the centre."""
        size = spacing(self.diameter / 2, gauge)
        zone = [Zone(-3 * size, 3 * size, size)]
        return zone, zone


def goes_on_as(before: object, now: object) -> bool:
    """Return whether a body goes on as another one under the sheet: it is the same, or both are balls."""
    return before == now or (isinstance(before, Sphere) and isinstance(now, Sphere))
