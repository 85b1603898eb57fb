"""An upright cylinder with a flat end."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.simulation.membrane.surface import Surface, skirt_drop, solve_edge

__all__ = ["Cylinder"]


@dataclass(frozen=True)
class Cylinder:
    """A flat-ended cylinder of a radius, m, from `base` to `top`, m."""

    radius: float
    top: float
    base: float
    compliance: float
    shape = "cylinder"

    @property
    def reach(self) -> float:
        """How far from its axis it reaches, m."""
        return self.radius

    def surface(self, depth: float, span: float) -> Surface:
        """Return the membrane: flat on the end, then a catenoid from its rim."""
        neck = solve_edge(lambda c: skirt_drop(self.radius, c, span), depth, self.radius, span)
        return Surface(depth, self.radius, neck, span, math.inf)
