"""Polyhedra that people know by a name: they stand or lie on the table, on a shank of their own outline, the top at z = 0."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import positive
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["arch", "pyramid", "triangular_prism"]

SHANK = 0.2  # m; longer than any press
_ARC = 12  # flat pieces of the opening of an arch

Corner = tuple[float, float]
Face = tuple[int, int, int]


@lru_cache(maxsize=32)
def triangular_prism(length: float, width: float, height: float, edge: float = 1e-3) -> Polyhedron:
    """Return a prism that lies on a face `length` x `width`, m, its sharp ridge along x and `height` above it, edges rounded."""
    for name, value in (("length", length), ("width", width), ("height", height)):
        positive(f"the {name} of a prism", value)
    b = width / 2
    outline = [(0.0, 0.0), (-b, -height), (-b, -height - SHANK), (b, -height - SHANK), (b, -height)]
    caps = [(0, 1, 4), (1, 2, 3), (1, 3, 4)]
    return _pulled(outline, caps, length, edge, along_x=True)


@lru_cache(maxsize=32)
def arch(length: float, width: float, height: float, span: float, edge: float = 1e-3) -> Polyhedron:
    """Return a block `length` x `width` x `height`, m, with a half-round opening of diameter `span` along y, edges rounded."""
    for name, value in (("length", length), ("width", width), ("height", height), ("span", span)):
        positive(f"the {name} of an arch", value)
    a, r, foot = length / 2, span / 2, -height - SHANK
    turns = np.linspace(math.pi, 0.0, _ARC + 1)
    opening = [(r * math.cos(t), r * math.sin(t) - height) for t in turns]
    outline = [(-a, 0.0), (-a, foot), (-r, foot), *opening, (r, foot), (a, foot), (a, 0.0)]
    last, crown = len(outline) - 1, 3 + _ARC // 2
    caps = [(0, k, k + 1) for k in range(1, crown)] + [(last, k, k + 1) for k in range(crown, last - 1)]
    return _pulled(outline, [*caps, (0, crown, last)], width, edge, along_x=False)


@lru_cache(maxsize=32)
def pyramid(side: float, height: float, edge: float = 1e-3) -> Polyhedron:
    """Return a pyramid on a square of `side`, m, its sharp point `height` above it, edges and point rounded."""
    positive("the side of a pyramid", side)
    positive("the height of a pyramid", height)
    square = side / 2 * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    rings = [np.column_stack([square, np.full(4, z)]) for z in (-height, -height - SHANK)]
    faces = [(0, 1 + k, 1 + (k + 1) % 4) for k in range(4)]
    for k in range(4):
        here, there = 1 + k, 1 + (k + 1) % 4
        faces += [(here, 4 + here, there), (there, 4 + here, 4 + there)]
    return Polyhedron(np.concatenate([[[0.0, 0.0, 0.0]], *rings]), np.array([*faces, (5, 7, 6), (5, 8, 7)]), edge)


def _pulled(outline: list[Corner], caps: list[Face], length: float, edge: float, *, along_x: bool) -> Polyhedron:
    """Return the body between two equal outlines, counter-clockwise as seen from the near end, its caps cut into triangles."""
    count, flat = len(outline), np.array(outline)
    ends = [np.insert(flat, 0 if along_x else 1, end, axis=1) for end in (length / 2, -length / 2)]
    far = [(c + count, b + count, a + count) for a, b, c in caps]
    sides = [
        face
        for k in range(count)
        for face in ((k, count + k, (k + 1) % count), ((k + 1) % count, count + k, count + (k + 1) % count))
    ]
    faces = np.array([*caps, *far, *sides])
    # seen from the near end, an outline in x and z runs the other way round than one in y and z
    return Polyhedron(np.concatenate(ends), faces if along_x else faces[:, ::-1], edge)
