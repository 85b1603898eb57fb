"""The part of a lump that the membrane meets: its upper side."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.dough.lump import Lump
from stretch_bt.simulation.membrane.indenters.height_field import HeightField

__all__ = ["UpperSide", "disc_side", "upper_side"]

BLURS = (0.0, 0.6, 1.0, 1.6)  # pitches
PITCH = 1.2e-3  # m; half the distance between 500 directions
STEEPEST = math.radians(65)  # where the membrane no longer reaches at a depth of half the radius


@dataclass(frozen=True, eq=False, repr=False)
class UpperSide(HeightField):
    """The upper side of a lump; the sheet's elements are as small as for the ball of the same volume, of `radius`, m.

    Its facets are shallow: elements that follow them twice as finely change the force by 0.1 %.
    """

    radius: float
    winding: ClassVar[bool] = False

    @property
    def tip_radius(self) -> float:
        """Radius of the ball, m."""
        return self.radius

    @property
    def feature(self) -> float:
        """Radius of the ball, m."""
        return self.radius


def upper_side(lump: Lump) -> UpperSide:
    """Return the upper side of a lump on a grid around its centroid, with a cone where it is steeper than 65 degrees.

    The heights are taken from radii averaged over about two directions to each side, and blurred further where a smooth surface
    through them would ring, as at an overhang; y is against the world's.

    Raises
    ------
    NoEquilibrium
        It is too ragged for any surface, as after far too much force.
    """
    from scipy.ndimage import gaussian_filter

    from stretch_bt.simulation.dough.surface_kernel import top_side

    vectors = np.ascontiguousarray(lump.directions.vectors @ lump.rotation.T * [1.0, -1.0, 1.0])
    count = 2 * math.ceil(1.1 * float(lump.radii.max()) / PITCH) + 1
    heights = top_side(lump.radii.copy(), vectors, PITCH, count, STEEPEST)
    for blur in BLURS:
        with suppress(InvalidInput):
            return UpperSide(gaussian_filter(heights, blur, mode="nearest") if blur else heights, PITCH, lump.ball)
    raise NoEquilibrium("the dough is too ragged to be met by the membrane")


def disc_side(line: npt.NDArray[np.float64], height: float, ball: float) -> UpperSide:
    """Return the upper side of a disc of an outline (n, 2), m, about its middle, and a height, m, on a grid as of a ball.

    Its top is flat, its side bulges in half a circle as high as it is; below the widest place the side goes straight down.
    """
    around = np.arctan2(line[:, 1], line[:, 0])
    order = np.argsort(around)
    away = np.linalg.norm(line, axis=1)
    bulge = min(height / 2, 0.9 * float(away.min()))
    count = 2 * math.ceil(1.15 * float(away.max()) / PITCH) + 1
    x, y = np.meshgrid(*[(np.arange(count) - (count - 1) / 2) * PITCH] * 2)
    edge = np.interp(np.arctan2(y, x), around[order], away[order], period=2 * np.pi)
    past = np.maximum(np.hypot(x, y) - (edge - bulge), 0.0)
    round_side = np.sqrt(np.maximum(bulge**2 - past**2, 0.0))
    # as steep as the side of a lump is drawn at most, and on from there
    start = bulge * math.sin(STEEPEST)
    cone = bulge * math.cos(STEEPEST) - (past - start) * math.tan(STEEPEST)
    return UpperSide(np.where(past < start, round_side, cone), PITCH, ball)
