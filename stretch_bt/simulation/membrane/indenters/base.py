"""An indenter: a rigid body that gives its signed distance, and where the sheet needs small elements.

A new shape is one file with one frozen dataclass that has the members of Indenter; Solid gives the members that most bodies
share, `shaft`, `cone`, `prism` and `capsule` of distance_kernel may help with the distance, plain numpy does as well.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.plain_numbers import is_number

__all__ = ["Gap", "Indenter", "Solid", "Zone", "empty_gap", "flatness", "positive", "spacing"]

Array = npt.NDArray[np.float64]
_FACE = 2.0  # radii of the edge from the middle of a face to where its edge begins, from which on it is one


class Gap(NamedTuple):
    """Signed distance (n,), m, outward normal (n, 3), and curvature (n, 6), 1/m: xx, xy, xz, yy, yz, zz."""

    distance: Array
    normal: Array
    curvature: Array


class Zone(NamedTuple):
    """Along one axis, from `low` to `high`, m, elements at most `size` long, m."""

    low: float
    high: float
    size: float


@runtime_checkable
class Indenter(Protocol):
    """A rigid body in its own frame: z up towards the sheet, the origin on its axis near its top."""

    @property
    def feature(self) -> float:
        """Smallest radius of curvature that the sheet bends around, m; sets how fine a mesh must be."""
        ...

    @property
    def tip_radius(self) -> float:
        """Radius, m, of the sphere that its top resembles; penetration is judged by it."""
        ...

    @property
    def flat(self) -> float:
        """Half the extent of its flat top, m; 0 for a body that is round on top."""
        ...

    @property
    def bulk(self) -> float:
        """Thickness from its top down, m: a guess that is further below has passed through it."""
        ...

    @property
    def peak(self) -> tuple[float, float]:
        """Place (x, y), m, of its highest point or of the middle of its flat top, untilted."""
        ...

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the extent of its top along x and y, m, after a rotation; a first guess of the sheet spans it."""
        ...

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, own frame; distance changes by at most |dx|."""
        ...

    def top(self, rotation: Array) -> float:
        """Return how far the highest point is above the origin, m, after a (3, 3) rotation."""
        ...

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return where small elements are needed along x and y, around the origin, on a sheet of this gauge, m."""
        ...


class Solid(ABC):
    """The common part of most bodies: round on top unless `flat` says otherwise, and going on downwards without end."""

    __slots__ = ()

    @property
    @abstractmethod
    def feature(self) -> float:
        """Smallest radius of curvature that the sheet bends around, m."""

    @property
    def tip_radius(self) -> float:
        """Radius of its top, m: the radius of its only feature."""
        return self.feature

    @property
    def flat(self) -> float:
        """0: it is round on top."""
        return 0.0

    @property
    def post(self) -> bool:
        """Whether its sides are its own, for the sheet to press on, and not of a shank that only holds it."""
        return self.flat > 0

    @property
    def bulk(self) -> float:
        """Endless: it goes on downwards."""
        return math.inf

    @property
    def peak(self) -> tuple[float, float]:
        """On its axis."""
        return 0.0, 0.0

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the extent of its flat top along x and y, m."""
        return self.flat, self.flat


def empty_gap(count: int) -> Gap:
    """Return room for `count` points."""
    return Gap(np.empty(count), np.empty((count, 3)), np.empty((count, 6)))


def spacing(radius: float, gauge: float) -> float:
    """Return the length of element, m, that resolves the edge of the contact with a sphere of this radius, m.

    The contact radius grows as the square root of radius x depth, and depths scale with the sheet.
    """
    return 0.015 * gauge * math.sqrt(10 * radius / gauge)


def flatness(flat: float, edge: float) -> float:
    """Return how far a top of half extent `flat`, m, within an edge of this radius, m, is a face: 1, or 0 for a round tip.

    In between it is a tip that the force spreads over, and all that tells faces from tips follows this share, so that no
    answer jumps where an edge takes the last of the face.
    """
    return min(1.0, flat / (_FACE * edge))


def positive(name: str, value: float, unit: str = "m") -> None:
    """Raise InvalidInput unless the value is a finite number above 0."""
    if not (is_number(value) and value > 0):
        raise InvalidInput(f"{name} must be a finite number above 0 {unit}, not {value!r}")
