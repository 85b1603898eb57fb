"""Every shape as a whole: far off and deep inside, where it ends, and of sizes that make no such shape."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.domains.indenters.shapes import SHAPES, field
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.membrane.indenters.base import Indenter, Zone
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.polyhedron import Polyhedron
from stretch_bt.simulation.membrane.indenters.ring import Ring
from stretch_bt.simulation.membrane.indenters.turned import Turned
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon

GAUGE = 0.1
_FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]


def _anywhere(shape: Indenter, count: int) -> tuple[float, float]:
    """Return the parts of places from 20 mm inside to 50 mm off whose normal, and outside whose curvature, are derivatives."""
    points = np.random.default_rng(11).uniform([-0.03, -0.03, -0.02], [0.03, 0.03, 0.05], (count, 3))
    gap, step = shape.gap(points), 1e-7
    around = [(shape.gap(points + e), shape.gap(points - e)) for e in step * np.eye(3)]
    slope = np.stack([(a.distance - b.distance) / (2 * step) for a, b in around], axis=1)
    bend = np.stack([(a.normal - b.normal) / (2 * step) for a, b in around], axis=1)
    full = gap.curvature[:, _FULL].reshape(-1, 3, 3)
    right = np.abs(slope - gap.normal).max(axis=1) < 1e-5
    bent = np.abs(bend - full).max(axis=(1, 2)) < 1e-3 * np.maximum(np.abs(full).max(axis=(1, 2)), 1.0)
    return float(right.mean()), float(bent[gap.distance > 0].mean())


def _under_a_top(heights: Any) -> list[float]:
    """Return distance, m, and curvature along z, 1/m, 5 mm under the top of a field, past its centre of curvature."""
    gap = field(heights, 33, 0.5e-3).gap(np.array([[0.0, 0.0, -0.005]]))
    return [float(gap.distance[0]), float(gap.curvature[0, 5])]


def _from_parabola(radius: float) -> list[float]:
    """Return the distance to a parabola from 5 mm under its top, m, and the curvature of its parallel there along z, 1/m."""
    stretched = math.sqrt(2 * 0.005 / radius - 1)  # of an arc of the nearest point over its projection
    return [-radius * stretched, 1 / (radius * stretched**3)]


def _centreline(wire: Any) -> Any:
    """Return points (n, 3), m, along the middle of a wire, 10 um apart or less."""
    if isinstance(wire, Wire):
        along = np.linspace(-wire.length / 2, wire.length / 2, 4001)
        return np.column_stack([along * math.cos(wire.heading), along * math.sin(wire.heading), 0 * along])
    turns = np.linspace(0, 2 * np.pi, 12001)
    if isinstance(wire, Ring):
        return wire.across / 2 * np.column_stack([np.cos(turns), np.sin(turns), 0 * turns])
    # the outline of a polygon that is rounded: its smaller self, and from there out by the bend
    inside = wire.side / (2 * math.tan(math.pi / wire.count))
    middles = math.pi / 2 + math.pi * (2 * np.arange(wire.count) + 1) / wire.count
    corners = [
        (inside - wire.bend) / math.cos(math.pi / wire.count) * np.array([math.cos(t), math.sin(t)])
        for t in middles - math.pi / wire.count
    ]
    pieces = []
    for k, middle in enumerate(middles):
        out, share = wire.bend * np.array([math.cos(middle), math.sin(middle)]), np.linspace(0, 1, 4001)[:, None]
        pieces.append(out + (1 - share) * corners[k] + share * corners[(k + 1) % wire.count])
        bends = middle + np.linspace(0, 2 * math.pi / wire.count, 801)
        pieces.append(corners[(k + 1) % wire.count] + wire.bend * np.column_stack([np.cos(bends), np.sin(bends)]))
    return np.column_stack([flat := np.concatenate(pieces), np.zeros(len(flat))])


def _off_wire(wire: Any) -> float:
    """Return how far the distance to a wire is off that to its middle less its radius, m."""
    points = np.random.default_rng(12).uniform(-0.025, 0.025, (2000, 3))
    true = cKDTree(_centreline(wire)).query(points)[0] - wire.diameter / 2
    return float(np.abs(wire.gap(points).distance - true).max())


def _ends(zones: list[Zone], places: Any, upright: bool) -> bool:
    """Whether zones are not empty and hold both ends of places (n,); of an upright body finely, and little else."""
    sound = all(z.low < z.high and 0 < z.size <= z.high - z.low for z in zones)
    size, ends = min(z.size for z in zones), (float(places.min()), float(places.max()))
    held = all(any(z.low < end < z.high and (z.size == size or not upright) for z in zones) for end in ends)
    far = max(ends[0] - min(z.low for z in zones), max(z.high for z in zones) - ends[1])
    return sound and held and (not upright or far < 6 * size)


def _zones_of(shape: Indenter, tilt: tuple[float, float]) -> bool:
    """Whether zones hold the ends of what lies within 50 um of the top of a body, or of a tilted one its highest place."""
    (body,) = place(shape, (0.001, -0.002), tilt, 0.0)
    around = max(shape.crest(np.eye(3))) + 2 * shape.feature
    points = np.random.default_rng(13).uniform([-around, -around, -5e-5], [around, around, 0.0], (40_000, 3))
    points[:, :2] += body.origin[:2]
    top = points[body.gap(points).distance < 0]
    if tilt != (0.0, 0.0):
        top = top[np.argmax(top[:, 2])][None]
    return all(_ends(zones, top[:, axis], tilt == (0.0, 0.0)) for axis, zones in enumerate(body.zones(GAUGE)))


def _sizes(shape: Indenter) -> list[float]:
    """Return how far its peak is off its surface, m, and how far its crest is off the reach of its top, over what a fillet hides."""
    (body,) = place(shape, (0.0, 0.0), (0.0, 0.0), 0.0)
    around = max(shape.crest(np.eye(3))) + 2 * shape.feature
    points = np.random.default_rng(14).uniform([-around, -around, -5e-5], [around, around, 0.0], (40_000, 3))
    top = np.abs(points[body.gap(points).distance < 0]).max(axis=0)[:2]
    round_to = max(shape.feature, getattr(shape, "diameter", 0.0) / 2)
    hidden = math.sqrt(2 * round_to * 5e-5) + 3e-4
    peak = body.gap(np.array([[*shape.peak, 0.0]])).distance
    return [float(np.abs(peak[0])), float(np.abs(top - shape.crest(np.eye(3))).max() / hidden)]


#: the last that there is, and the first that there is not; a polygon's sides touch a circle of side / (2 tan(pi / count))
_INSIDE = 0.02 / (2 * math.tan(math.pi / 3))
LIMITS: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
    "a fillet of half a cube": (partial(Cube, 0.02, 0.01), partial(Cube, 0.02, 0.0101)),
    "a fillet of half a box": (partial(Box, 0.01, 0.016, 0.0, 0.005), partial(Box, 0.01, 0.016, 0.0, 0.0051)),
    "a fillet of half a long box": (partial(Box, 0.016, 0.01, 0.0, 0.005), partial(Box, 0.016, 0.01, 0.0, 0.0051)),
    "a rim of a cylinder's radius": (partial(Cylinder, 0.02, 0.01), partial(Cylinder, 0.02, 0.0101)),
    "a fillet of half a half cylinder": (
        partial(HalfCylinder, 0.012, 0.02, 0.0059),
        partial(HalfCylinder, 0.012, 0.02, 0.006),
    ),
    "a fillet of half a short half cylinder": (
        partial(HalfCylinder, 0.02, 0.012, 0.0059),
        partial(HalfCylinder, 0.02, 0.012, 0.006),
    ),
    "a cone of 90 degrees": (partial(Cone, 1.57), partial(Cone, math.pi / 2)),
    "a ring without a hole": (partial(Ring, 0.002, 0.0021), partial(Ring, 0.002, 0.002)),
    "a polygon of two sides": (partial(WirePolygon, 0.002, 0.02, 3), partial(WirePolygon, 0.002, 0.02, 2)),
    "a polygon of a hundred sides": (partial(WirePolygon, 0.002, 0.02, 100), partial(WirePolygon, 0.002, 0.02, 101)),
    "a polygon without a hole": (partial(WirePolygon, 0.002, 0.0041, 6), partial(WirePolygon, 0.002, 0.004, 6)),
    "a bend outwards": (partial(WirePolygon, 0.002, 0.02, 3, 0.0), partial(WirePolygon, 0.002, 0.02, 3, -1e-6)),
    "a bend of whole sides": (
        partial(WirePolygon, 0.002, 0.02, 3, _INSIDE - 0.0021),
        partial(WirePolygon, 0.002, 0.02, 3, _INSIDE - 0.002),
    ),
}
#: shapes that have a size, and fields that may be of any size
SIZED = {n: s for n, s in SHAPES.items() if not isinstance(s, Turned | Polyhedron) and n != "height field"}
FREE = ("angle", "heading", "count", "bend")


def _of_no_size() -> Iterator[Hard]:
    for name, shape in SIZED.items():
        sizes = [f.name for f in fields(_dataclass(shape)) if f.name not in FREE]
        rows = {
            f"{name} with {size} {value:g}": (
                partial(replace, _dataclass(shape), **{size: value}),
                Refusal(InvalidInput),
            )
            for size in sizes
            for value in (0.0, -0.001, math.nan, math.inf)
        }
        yield from group("a size of nothing, less than that, or no number makes no shape", rows)


def _dataclass(shape: Indenter) -> Any:
    return shape


#: shapes whose zones are tested; the top of a field is the part within a share of its own of the height
ZONED = {name: shape for name, shape in SHAPES.items() if "height field" not in name}
WIRES = {
    "wire": Wire(0.0015, 0.03, 0.4),
    "ring": Ring(0.002, 0.02),
    "triangle of wire": WirePolygon(0.002, 0.02),
    "square of wire, bent": WirePolygon(0.002, 0.02, 4, 0.003),
    "hexagon of wire, bent": WirePolygon(0.002, 0.008, 6, 0.002),
}
CASES: tuple[Hard, ...] = (
    *group(
        "far off, and deep inside, the nearest part of a shape is another one than close to its surface",
        {
            f"{name}, anywhere": (
                partial(_anywhere, shape, 60 if "field" in name else 600),
                Check("normals at 98 % of places, curvature at 98 % of those outside", lambda f: min(f) > 0.98),
            )
            for name, shape in SHAPES.items()
        },
        {
            f"{name}, against its middle line": (partial(_off_wire, wire), Range(0.0, 1e-7))
            for name, wire in WIRES.items()
        },
    ),
    *group(
        "past a centre of curvature the point above is not the nearest one",
        {
            # all around a dome points are as near: the distance bends across to them without bound, which is left out
            "under a dome": (
                partial(_under_a_top, lambda x, y: -(x**2 + y**2) / 0.008),
                Value([_from_parabola(0.004)[0], 0.0], rel=1e-4),
            ),
            "under a ridge along x": (
                partial(_under_a_top, lambda x, y: -(y**2) / 0.006 + 0 * x),
                Value(_from_parabola(0.003), rel=1e-2),
            ),
            "under a ridge along y": (
                partial(_under_a_top, lambda x, y: -(x**2) / 0.006 + 0 * y),
                Value(_from_parabola(0.003), rel=1e-2),
            ),
        },
    ),
    *group(
        "a mesh is as fine as a body asks for, where it asks for it",
        {
            f"{name}, zones{'' if tilt == (0.0, 0.0) else ' of it tilted'}": (
                partial(_zones_of, shape, tilt),
                Value(True),
            )
            for name, shape in ZONED.items()
            for tilt in ((0.0, 0.0), (0.1, -0.05))
        },
    ),
    *group(
        "a first guess of the sheet spans the top, and the hand goes down on the peak",
        {
            f"{name}, peak and crest": (
                partial(_sizes, shape),
                Check("the peak on the surface, the crest as far as the top", lambda f: f[0] < 1e-9 and f[1] < 1),
            )
            for name, shape in {**ZONED, "turned cube": Turned(Cube(0.02), 0.6)}.items()
        },
    ),
    *group(
        "a shape is made up to a last size, and refused from the next one on",
        {f"{name}, nearly": (last, Check("made", lambda _: True)) for name, (last, _) in LIMITS.items()},
        {f"{name}": (first, Refusal(InvalidInput)) for name, (_, first) in LIMITS.items()},
    ),
    *_of_no_size(),
)
