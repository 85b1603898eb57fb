"""What the membrane meets of a lump: its upper side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.simulation.dough.lump import Lump
from stretch_bt.simulation.membrane.indenters.height_field import HeightField

__all__ = ["UpperSide", "upper_side"]

PITCH = 1.2e-3  # m; half the distance between 500 directions
STEEPEST = math.radians(65)  # where the membrane no longer reaches at a depth of half the radius


@dataclass(frozen=True, eq=False, repr=False)
class UpperSide(HeightField):
    """The upper side of a lump; the sheet's elements are as small as for the ball of the same volume, of `radius`, m.

    Its facets are shallow: elements that follow them twice as finely change the force by 0.1 %.
    """

    radius: float

    @property
    def tip_radius(self) -> float:
        """That of the ball, m."""
        return self.radius

    @property
    def feature(self) -> float:
        """That of the ball, m."""
        return self.radius


def upper_side(lump: Lump) -> UpperSide:
    """Return the upper side of a lump on a grid around its centroid, with a cone for what is steeper than 65 degrees.

    The heights are taken from radii averaged over about two directions to each side.
    """
    from stretch_bt.simulation.dough.surface_kernel import top_side

    vectors = np.ascontiguousarray(lump.directions.vectors @ lump.rotation.T)
    count = 2 * math.ceil(1.1 * float(lump.radii.max()) / PITCH) + 1
    return UpperSide(top_side(lump.radii.copy(), vectors, PITCH, count, STEEPEST), PITCH, lump.ball)
