"""A level face wider than the membrane."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stretch_bt.simulation.membrane.surface import Surface

__all__ = ["Plane"]


@dataclass(frozen=True)
class Plane:
    """A block whose flat top spans the whole membrane.

    Its force is that of a flat-ended cylinder as wide as the calibration reaches, 80 mm.
    """

    top: float
    base: float
    compliance: float
    shape = "cylinder"
    radius = 0.040
    reach = math.inf

    def surface(self, depth: float, span: float) -> Surface:
        """Return the membrane, flat all over."""
        return Surface(depth, math.inf, 0.0, math.inf, math.inf)
