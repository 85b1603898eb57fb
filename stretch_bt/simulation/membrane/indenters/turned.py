"""An indenter turned about its own upright axis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Indenter, Solid, Zone
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere

__all__ = ["Turned", "turn"]


def turn(body: Indenter | Several, heading: float) -> Indenter | Several:
    """Return a body turned by `heading`, rad, from x to y about the z axis of its origin.

    Bodies of revolution stay as they are; the parts of several move around their common origin.

    Raises
    ------
    InvalidInput
        The heading is not a finite number.
    """
    if not math.isfinite(heading):
        raise InvalidInput(f"a heading must be a finite number of rad, not {heading!r}")
    if heading == 0.0 or isinstance(body, Sphere | Cylinder | Cone):
        return body
    if isinstance(body, Several):
        c, s = math.cos(heading), math.sin(heading)
        return Several(tuple(Part(_one(p.indenter, heading), _about(p.at, c, s), p.below) for p in body.parts))
    return _one(body, heading)


def _one(body: Indenter, heading: float) -> Indenter:
    if isinstance(body, Sphere | Cylinder | Cone):
        return body
    if isinstance(body, Turned):
        return Turned(body.indenter, body.heading + heading)
    return Turned(body, heading)


def _about(place: tuple[float, float], c: float, s: float) -> tuple[float, float]:
    return c * place[0] - s * place[1], s * place[0] + c * place[1]


@dataclass(frozen=True, slots=True)
class Turned(Solid):
    """An indenter turned by `heading`, rad, from x to y about the z axis of its origin."""

    indenter: Indenter
    heading: float

    def __post_init__(self) -> None:
        if not math.isfinite(self.heading):
            raise InvalidInput(f"a heading must be a finite number of rad, not {self.heading!r}")

    @property
    def _rotation(self) -> Array:
        """The (3, 3) rotation from the body's own axes."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    @property
    def feature(self) -> float:
        """The body's own, m."""
        return self.indenter.feature

    @property
    def tip_radius(self) -> float:
        """The body's own, m."""
        return self.indenter.tip_radius

    @property
    def flat(self) -> float:
        """The body's own, m."""
        return self.indenter.flat

    @property
    def post(self) -> bool:
        """The body's own."""
        return bool(getattr(self.indenter, "post", self.flat > 0))

    @property
    def bulk(self) -> float:
        """The body's own, m."""
        return self.indenter.bulk

    @property
    def peak(self) -> tuple[float, float]:
        """Place (x, y), m, that its highest point is turned to."""
        return _about(self.indenter.peak, math.cos(self.heading), math.sin(self.heading))

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return half the extent of its top along x and y, m."""
        return self.indenter.crest(rotation @ self._rotation)

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.distance_kernel import rotate

        rotation = self._rotation
        gap = self.indenter.gap(np.ascontiguousarray(points @ rotation))
        rotate(rotation, gap.normal, gap.curvature)
        return gap

    def top(self, rotation: Array) -> float:
        """Return the height of its highest point above the origin, m."""
        return self.indenter.top(rotation @ self._rotation)

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return where small elements are needed along x and y."""
        return self.indenter.zones(rotation @ self._rotation, gauge)
