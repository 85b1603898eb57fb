"""Polyhedra that people know by a name: they stand or lie on the table, on a shank of their own outline."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import positive
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron

__all__ = ["pyramid", "triangular_prism"]

SHANK = 0.2  # m; longer than any press


def triangular_prism(length: float, width: float, height: float, edge: float = 1e-3) -> Polyhedron:
    """Return a prism that lies on a face `length` x `width`, m, its ridge along x and `height` above it at z = 0, edges rounded."""
    for name, value in (("length", length), ("width", width), ("height", height)):
        positive(f"the {name} of a prism", value)
    a, b = length / 2, width / 2
    end = np.array(
        [[0.0, 0.0, 0.0], [0.0, -b, -height], [0.0, -b, -height - SHANK], [0.0, b, -height - SHANK], [0.0, b, -height]]
    )
    vertices = np.concatenate([end + np.array([side, 0.0, 0.0]) for side in (a, -a)])
    cap = [[0, 1, 4], [1, 2, 3], [1, 3, 4]]
    sides = [t for k in range(5) for t in ([k, 5 + k, (k + 1) % 5], [(k + 1) % 5, 5 + k, 5 + (k + 1) % 5])]
    return Polyhedron(vertices, np.array([*cap, *[[c + 5, b + 5, a + 5] for a, b, c in cap], *sides]), edge)


def pyramid(side: float, height: float, edge: float = 1e-3) -> Polyhedron:
    """Return a pyramid on a square of `side`, m, its point `height` above it at z = 0, edges and point rounded."""
    positive("the side of a pyramid", side)
    positive("the height of a pyramid", height)
    square = side / 2 * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    rings = [np.column_stack([square, np.full(4, z)]) for z in (-height, -height - SHANK)]
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], *rings])
    faces = [[0, 1 + k, 1 + (k + 1) % 4] for k in range(4)]
    for k in range(4):
        here, there = 1 + k, 1 + (k + 1) % 4
        faces += [[here, 4 + here, there], [there, 4 + here, 4 + there]]
    return Polyhedron(vertices, np.array([*faces, [5, 7, 6], [5, 8, 7]]), edge)
