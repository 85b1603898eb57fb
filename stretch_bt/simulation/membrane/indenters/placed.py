"""An indenter somewhere in the membrane frame, which the sheet presses against."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Indenter, Zone
from stretch_bt.simulation.membrane.indenters.several import Part, Several

__all__ = ["Placed", "origin_below_top", "place", "rise"]


@dataclass(frozen=True, slots=True)
class Placed:
    """An indenter with its origin (3,), m, and its rotation (3, 3) in the membrane frame."""

    indenter: Indenter
    origin: Array
    rotation: Array
    turned: bool

    @property
    def top(self) -> float:
        """Height of its highest point, m."""
        return float(self.origin[2]) + self.rise

    @property
    def rise(self) -> float:
        """How far its highest point is above its origin, m."""
        return self.indenter.top(self.rotation)

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m, membrane frame."""
        return self.gap_seen(np.ascontiguousarray((points - self.origin) @ self.rotation))

    def gap_seen(self, points: Array) -> Gap:
        """Return the same at points (n, 3), m, as the body sees them: from its origin, in its own frame."""
        gap = self.indenter.gap(points)
        if self.turned:
            from stretch_bt.simulation.membrane.indenters.distance_kernel import rotate

            rotate(self.rotation, gap.normal, gap.curvature)
        return gap

    def zones(self, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return where small elements are needed along x and y, m, membrane frame."""
        along = self.indenter.zones(self.rotation, gauge)
        x, y = (
            [Zone(z.low + o, z.high + o, z.size) for z in zones]
            for zones, o in zip(along, self.origin[:2].tolist(), strict=True)
        )
        return x, y


def place(
    indenter: Indenter | Several, at: tuple[float, float], tilt: tuple[float, float], depth: float
) -> tuple[Placed, ...]:
    """Return the bodies of an indenter with its origin over (x, y), m, and its highest point at z = depth, m.

    `tilt` turns it about its origin by tilt[0], rad, about x and then by tilt[1] about y.
    """
    if not all(math.isfinite(v) for v in (*at, *tilt, depth)):
        raise InvalidInput(f"a place needs finite numbers, not at={at}, tilt={tilt}, depth={depth}")
    if not all(abs(t) < math.pi / 2 for t in tilt):
        raise InvalidInput(f"a tilt must stay within 90 degrees, not {tilt} rad")
    rotation, turned = _tilted(tilt), tuple(tilt) != (0.0, 0.0)
    parts = _parts(indenter)
    origins = _origins(parts, rotation)
    highest = _highest(parts, origins, rotation)
    if len(parts) == 1:
        origins[0][:2] = 0.0
    shift = np.array([at[0], at[1], depth - highest])
    return tuple(Placed(p.indenter, o + shift, rotation, turned) for p, o in zip(parts, origins, strict=True))


def origin_below_top(indenter: Indenter | Several) -> float:
    """Return how far the place that `at` speaks of lies below the highest point of an upright indenter, m."""
    return 0.0 if isinstance(indenter, Several) and len(indenter.parts) > 1 else _parts(indenter)[0].indenter.top(_FLAT)


def rise(indenter: Indenter | Several, tilt: tuple[float, float]) -> float:
    """Return how far the highest point of a tilted indenter lies above that place, m."""
    parts, rotation = _parts(indenter), _tilted(tilt)
    if len(parts) == 1:
        return parts[0].indenter.top(rotation)
    return _highest(parts, _origins(parts, rotation), rotation)


_FLAT = np.eye(3)


def _parts(indenter: Indenter | Several) -> tuple[Part, ...]:
    return indenter.parts if isinstance(indenter, Several) else (Part(indenter, (0.0, 0.0)),)


def _origins(parts: tuple[Part, ...], rotation: Array) -> list[Array]:
    """Return the origins of the parts: before any tilt each one's top lies `below` the highest."""
    return [rotation @ np.array([*p.at, -p.below - p.indenter.top(_FLAT)]) for p in parts]


def _highest(parts: tuple[Part, ...], origins: list[Array], rotation: Array) -> float:
    return max(float(o[2]) + p.indenter.top(rotation) for o, p in zip(origins, parts, strict=True))


def _tilted(tilt: tuple[float, float]) -> Array:
    (ca, sa), (cb, sb) = ((math.cos(t), math.sin(t)) for t in tilt)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]])
    about_y = np.array([[cb, 0.0, sb], [0.0, 1.0, 0.0], [-sb, 0.0, cb]])
    return np.asarray(about_y @ about_x)
