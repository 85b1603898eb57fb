"""A sphere that keeps its shape and gives way as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.simulation.membrane.surface import Surface, skirt_drop, solve_edge

__all__ = ["Sphere"]


@dataclass(frozen=True)
class Sphere:
    """A sphere of a radius, m, whose lowest point stands at `base`, m."""

    radius: float
    base: float
    compliance: float
    shape = "sphere"

    @property
    def top(self) -> float:
        """World height of the undeformed top, m."""
        return self.base + 2 * self.radius

    @property
    def reach(self) -> float:
        """How far from its axis it reaches, m."""
        return self.radius

    def surface(self, depth: float, span: float) -> Surface:
        """Return the membrane: the cap up to the contact radius a, then a catenoid with neck a^2 / R."""
        edge = solve_edge(lambda a: self._cap(a) + skirt_drop(a, a * a / self.radius, span), depth, self.radius, span)
        return Surface(depth, edge, edge * edge / self.radius, span, self.radius)

    def _cap(self, a: float) -> float:
        return a * a / (self.radius + math.sqrt(max(self.radius**2 - a * a, 0.0)))  # without cancellation
