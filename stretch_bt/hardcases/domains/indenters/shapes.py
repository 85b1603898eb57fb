"""Every shape: its normal and curvature are derivatives of its distance, and its top is where it is put."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.hardcases.expect import Check, Range, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.ring import Ring
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.shapes import pyramid, triangular_prism
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import Turned, turn
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon

TILTS = ((0.0, 0.0), (0.2, -0.3))
_FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]


def field(surface: Any, count: int = 51, pitch: float = 0.5e-3) -> HeightField:
    """Return the height field of a function of x and y, m, over a square around the origin."""
    x = (np.arange(count) - (count - 1) / 2) * pitch
    return HeightField(surface(*np.meshgrid(x, x)), pitch)


BUMP = field(lambda x, y: 0.008 * np.exp(-((x - 0.002) ** 2 + 1.6 * (y + 0.001) ** 2 + 0.4 * x * y) / 6e-5))
SHAPES: dict[str, Indenter] = {
    "sphere": Sphere(0.02),
    "cylinder": Cylinder(0.02),
    "cone": Cone(math.pi / 4),
    "cube": Cube(0.02),
    "box": Box(0.01, 0.016, 0.4),
    "wire": Wire(0.0015, 0.03, 0.4),
    "height field": BUMP,
    "turned height field": Turned(BUMP, 0.7),
    "half cylinder": HalfCylinder(0.012, 0.02),
    "ring": Ring(0.002, 0.02),
    "triangle of wire": WirePolygon(0.002, 0.02),
    "square of wire": WirePolygon(0.002, 0.02, 4, 0.003),
    "prism": triangular_prism(0.02, 0.012, 0.01),
    "pyramid": pyramid(0.02, 0.012),
    "turned box": Turned(Box(0.01, 0.016), 0.4),
}
#: seconds, and like the others in what they ask
COSTLY = ("turned height field",)


def _near_surface(body: Any) -> Any:
    """Return points near the upper surface of a placed body."""
    points = np.random.default_rng(1).uniform(-0.014, 0.014, (40_000, 3)) + body.origin
    return points[np.abs(body.gap(points).distance) < 0.3 * body.indenter.feature][:300]


def _derived(shape: Indenter, tilt: tuple[float, float]) -> tuple[float, float, float, int]:
    """Return errors of normals and of their lengths, the part of places whose curvature is right, and their number."""
    (body,) = place(shape, (0.003, -0.002), tilt, 0.01)
    points, step = _near_surface(body), 1e-7
    gap, moves = body.gap(points), step * np.eye(3)
    around = [(body.gap(points + e), body.gap(points - e)) for e in moves]
    slope = np.stack([(a.distance - b.distance) / (2 * step) for a, b in around], axis=1)
    bend = np.stack([(a.normal - b.normal) / (2 * step) for a, b in around], axis=1)
    full = gap.curvature[:, _FULL].reshape(-1, 3, 3)
    # faces, fillets and flanks meet with a jump of the curvature: few points straddle one
    smooth = np.abs(bend - full).max(axis=(1, 2)) < 1e-3 * max(np.abs(full).max(), 1.0)
    lengths = np.abs(np.linalg.norm(gap.normal, axis=1) - 1).max()
    return float(np.abs(slope - gap.normal).max()), float(lengths), float(smooth.mean()), len(points)


def _consistent(shape: Indenter) -> list[tuple[float, float, float, int]]:
    return [_derived(shape, tilt) for tilt in TILTS]


def _is_derived(found: list[tuple[float, float, float, int]]) -> bool:
    return all(n > 30 and right > 0.98 and off < 1e-5 and length < 1e-12 for off, length, right, n in found)


def _tops(shape: Indenter) -> list[tuple[float, float]]:
    """Return the highest place inside a body that is put to 10 mm, and how near it comes to that height, m, for each tilt."""
    found = []
    for tilt in TILTS:
        (body,) = place(shape, (0.0, 0.0), tilt, 0.01)
        points = body.origin + np.random.default_rng(2).uniform(-0.02, 0.02, (200_000, 3))
        points = points[points[:, 2] > 0.008]  # the highest is among these
        inside = points[body.gap(points).distance < 0]
        above = np.column_stack([points[:, :2], np.full(len(points), 0.01)])
        found.append((float(inside[:, 2].max()), float(body.gap(above).distance.min())))
    return found


def _at_the_depth(found: list[tuple[float, float]]) -> bool:
    return all(top <= 0.01 + 1e-12 and -1e-12 < near < 2e-4 for top, near in found)


def _steepest(shape: Indenter) -> float:
    """Return how much faster than the place the distance changes anywhere."""
    one, other = np.random.default_rng(3).uniform(-0.03, 0.03, (2, 5000, 3))
    change = np.abs(shape.gap(one).distance - shape.gap(other).distance)
    return float((change / np.linalg.norm(one - other, axis=1)).max())


def _turned_alike() -> float:
    """Return by how much the distance to a turned box differs, at turned points, m."""
    c, s = math.cos(0.4), math.sin(0.4)
    points = np.random.default_rng(4).uniform(-0.02, 0.02, (500, 3))
    turned = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    plain = Box(0.01, 0.016)
    moved = turn(plain, 0.4)
    assert isinstance(moved, Turned)
    other = Box(0.01, 0.016, 0.4).gap(points).distance
    return float(
        max(
            np.abs(moved.gap(turned).distance - plain.gap(points).distance).max(),
            np.abs(moved.gap(points).distance - other).max(),
        )
    )


def _grouped() -> list[float]:
    """Return the tops and the places across of two balls, one of them lower, put to 8 mm at y = 10 mm."""
    pair = Several((Part(Sphere(0.01), (-0.015, 0.0)), Part(Sphere(0.02), (0.015, 0.0), 0.002)))
    left, right = place(pair, (0.0, 0.01), (0.0, 0.0), 0.008)
    return [left.top, right.top, *left.origin[:2], *right.origin[:2]]


def _turned_group() -> list[float]:
    pair = turn(Several((Part(Sphere(0.01), (0.01, 0.0)), Part(Cube(0.02), (0.0, 0.02), 0.002))), math.pi / 2)
    assert isinstance(pair, Several)
    assert pair.parts[1].indenter == Turned(Cube(0.02), math.pi / 2)
    return [*pair.parts[0].at, *pair.parts[1].at, pair.parts[1].below]


DERIVED = Check("normals within 1e-5, curvature at 98 % of places", _is_derived)
AT_THE_DEPTH = Check("nothing above 10 mm, and something within 0.2 mm of it", _at_the_depth)

CASES: tuple[Hard, ...] = (
    *group(
        "the solver follows normals and curvatures: one that is not the derivative of the distance leads it astray",
        {f"{name}, derivatives": (partial(_consistent, shape), DERIVED) for name, shape in SHAPES.items()},
        {"cone with a blunt tip, derivatives": (partial(_consistent, Cone(math.pi / 4, 0.008)), DERIVED)},
    ),
    *group(
        "depth is measured to the highest point, which is another one on a tilted body",
        {f"{name}, top": (partial(_tops, shape), AT_THE_DEPTH) for name, shape in SHAPES.items()},
        costly=tuple(f"{name}, top" for name in COSTLY),
    ),
    *group(
        "a distance that changes faster than the place lets a step go through the body",
        {f"{name}, steepest": (partial(_steepest, shape), Range(0.0, 1 + 1e-9)) for name, shape in SHAPES.items()},
    ),
    *group(
        "a turn goes round the axis, moves the places of a group's parts, and adds to an earlier turn",
        {
            "a turned box is the box in turned axes": (_turned_alike, Value(0.0, abs=1e-15)),
            "a group keeps its parts apart": (_grouped, Value([0.008, 0.006, -0.015, 0.01, 0.015, 0.01], rel=1e-9)),
            "a group turns": (_turned_group, Value([0.0, 0.01, -0.02, 0.0, 0.002], abs=1e-15)),
            "a body of revolution stays": (lambda: turn(Sphere(0.02), 1.0), Value(Sphere(0.02))),
            "turns add up": (lambda: turn(turn(Cube(0.02), 0.2), 0.3), Value(Turned(Cube(0.02), 0.5))),
        },
    ),
)
