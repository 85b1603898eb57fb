"""Quadratic B-splines on one axis: knots, Greville points, and tables of the basis at Gauss points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

__all__ = ["Axis", "BasisTable"]

Array = npt.NDArray[np.float64]
_GAUSS = {count: np.polynomial.legendre.leggauss(count) for count in (2, 4)}


@dataclass(frozen=True, slots=True)
class BasisTable:
    """Basis at the Gauss points of every element: value, slope and bend (e, q, 3), weights and places (e, q)."""

    value: Array
    slope: Array
    bend: Array
    weight: Array
    place: Array


@dataclass(frozen=True)
class Axis:
    """Open quadratic splines over rising breakpoints (n + 1,); n + 2 functions, three of them on each element."""

    breaks: Array

    @cached_property
    def knots(self) -> Array:
        """(n + 5,) float, the breakpoints with both ends threefold."""
        return np.concatenate([[self.breaks[0]] * 2, self.breaks, [self.breaks[-1]] * 2])

    @cached_property
    def greville(self) -> Array:
        """(n + 2,) float, the places whose control values reproduce a linear function."""
        return (self.knots[1:-2] + self.knots[2:-1]) / 2

    @property
    def elements(self) -> int:
        """How many elements there are."""
        return len(self.breaks) - 1

    def gauss(self, count: int) -> BasisTable:
        """Return the tables at `count` Gauss points an element."""
        points, weights = _GAUSS[count]
        middle, half = (self.breaks[1:] + self.breaks[:-1]) / 2, np.diff(self.breaks) / 2
        place = middle[:, None] + half[:, None] * points
        value, slope, bend = self.basis(np.arange(self.elements)[:, None], place)
        return BasisTable(value, slope, bend, half[:, None] * weights, place)

    def basis(self, element: npt.ArrayLike, u: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Return value, first and second derivative (..., 3) of the functions of `element` (...) at places u (...)."""
        e, u = np.asarray(element), np.asarray(u, dtype=float)
        a, b, c, d = (self.knots[e + k] for k in (1, 2, 3, 4))
        left, right = 1 / ((c - a) * (c - b)), 1 / ((d - b) * (c - b))
        first, last = (c - u) ** 2 * left, (u - b) ** 2 * right
        down, up = -2 * (c - u) * left, 2 * (u - b) * right
        curl = np.broadcast_arrays(2 * left, 2 * right, first)[:2]
        return (
            np.stack([first, 1 - first - last, last], axis=-1),
            np.stack([down, -down - up, up], axis=-1),
            np.stack([curl[0], -curl[0] - curl[1], curl[1]], axis=-1),
        )

    def locate(self, u: npt.ArrayLike) -> npt.NDArray[np.intp]:
        """Return the element of each place; places beyond an end count to the last element there."""
        return np.clip(np.searchsorted(self.breaks, u, side="right") - 1, 0, self.elements - 1)
