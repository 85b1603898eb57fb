"""The true upper surface of an object of the twin, which a press from above could feel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.objects.base import ObjectSpec

__all__ = ["Above", "distances", "upper_surface"]

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STEPS = 80
_CLOSE = 2e-5  # m
_STEEP = np.cos(np.radians(45.0))
_MIRROR = np.array([1.0, -1.0, 1.0])  # bodies are in the frame of the membrane


@dataclass(frozen=True, slots=True)
class Above:
    """The upper surface of an object: places (n, 2), heights (n,), m, world, and areas (n,), m^2, whose normals are within 45 degrees of vertical."""

    places: Array
    heights: Array
    areas: Array


def upper_surface(spec: ObjectSpec, cell: float = 1e-3) -> Above:
    """Return the upper surface of an undeformed object, by rays from above in square cells.

    Raises
    ------
    InvalidInput
        The object has no body.
    """
    _body(spec)  # what has none has no end
    reach = np.arange(-spec.reach - 2 * cell, spec.reach + 2 * cell, cell)
    x, y = (axis.ravel() for axis in np.meshgrid(reach, reach, indexing="ij"))
    points = np.column_stack([x + spec.position.x, y + spec.position.y, np.full(x.shape, spec.top + cell)])
    for _ in range(_STEPS):
        points[:, 2] -= np.maximum(distances(spec, points), 0.0)
    away = _gap(spec, points)
    there = (np.abs(away[0]) < _CLOSE) & (points[:, 2] > spec.base) & (away[1][:, 2] > _STEEP)
    return Above(points[there, :2], points[there, 2], cell**2 / away[1][there, 2])


def distances(spec: ObjectSpec, points: Array) -> Array:
    """Return how far points (n, 3), m, world, are outside the surface of an undeformed object, m."""
    return _gap(spec, points)[0]


def _body(spec: ObjectSpec) -> Indenter | Several:
    body = spec.body()
    if body is None:
        raise InvalidInput(f"a {spec.type} has no body; name an object that has a shape")
    return body


def _gap(spec: ObjectSpec, points: Array) -> tuple[Array, Array]:
    """Return distance (n,), m, and upward part of the outward normal in the last column (n, 3)."""
    body = _body(spec)
    c, s = np.cos(spec.heading), np.sin(spec.heading)
    away = points - [spec.position.x, spec.position.y, spec.top]
    own = np.column_stack([c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0], away[:, 2]]) * _MIRROR
    if not isinstance(body, Several):
        return _of_one(body, own)
    found = [_of_one(p.indenter, own - [*p.at, -p.below]) for p in body.parts]
    nearest = np.argmin([f[0] for f in found], axis=0)
    rows = np.arange(len(own))
    return np.array([f[0] for f in found])[nearest, rows], np.array([f[1] for f in found])[nearest, rows]


def _of_one(body: Indenter, points: Array) -> tuple[Array, Array]:
    gap = body.gap(np.ascontiguousarray(points + np.array([0.0, 0.0, body.top(np.eye(3))])))
    return gap.distance, gap.normal
