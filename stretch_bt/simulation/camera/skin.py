"""The scene that the camera looks at, membrane frame: the membrane as a profile or as a grid of points, and the table behind it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.simulation.membrane.surface import Surface

__all__ = ["Grid", "Plane", "RoundBump", "Skin", "table_under"]

_LEAST = 3  # points to a side; a surface is continued beyond its sides by parabolas


@dataclass(frozen=True, slots=True)
class Plane:
    """The points p of the membrane frame with normal . p = offset, m; the normal points to the camera's side."""

    normal: tuple[float, float, float]
    offset: float


@dataclass(frozen=True, slots=True)
class RoundBump:
    """A flat sheet of `width` by `length`, m, round its centre, with a bump around an axis at (x, y), m.

    `surface` is the bump's profile; None is none, and one of infinite span lifts the whole sheet.
    """

    surface: Surface | None
    axis: tuple[float, float]
    width: float
    length: float

    @property
    def ends(self) -> tuple[float, float]:
        """Where the fingers hold it, y, m."""
        return -self.length / 2, self.length / 2


@dataclass(frozen=True, slots=True)
class Grid:
    """A surface as points (rows, columns, 3) float, m: x grows with the columns, y with the rows, held at its end rows."""

    points: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        shape = self.points.shape
        if len(shape) != 3 or shape[2] != 3 or min(shape[:2]) < _LEAST:
            raise InvalidInput(f"a surface is points (rows, columns, 3), at least {_LEAST} to a side, got {shape}")
        if not np.isfinite(self.points).all():
            raise InvalidInput("a surface is of finite points")

    @property
    def ends(self) -> tuple[float, float]:
        """Where the fingers hold it, y, m."""
        return float(self.points[0, :, 1].mean()), float(self.points[-1, :, 1].mean())


Skin = RoundBump | Grid


def table_under(hand: Pose) -> Plane:
    """Return the table, the world's z = 0, as the membrane frame of a hand has it; that frame's y is the hand's reversed."""
    x, y, z = hand.matrix()[2]
    return Plane((float(x), -float(y), float(z)), -hand.height)
