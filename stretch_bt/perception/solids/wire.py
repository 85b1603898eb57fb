"""A wire that lies flat, bent to a circle or to a triangle."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.bend import Bend, fit_bend
from stretch_bt.perception.solids.conformity import inside_wire
from stretch_bt.perception.solids.outline import Fitted, Rays, circle_outline
from stretch_bt.perception.solids.profile import profile_of
from stretch_bt.perception.solids.result import Dimension, Solid, pooled
from stretch_bt.perception.solids.views import SolidView

__all__ = ["is_hollow", "no_wire_there", "wire_circle", "wire_triangle"]

Array = npt.NDArray[np.float64]

HOLLOW = 0.06e-3  # m, least sag of the membrane inside a wire: how much lower its middle hangs than near the wire
SHARED = 0.25e-3  # m, error of the middle of a wire: of a circle's radius, of a side, and of the sum of a triangle's three sides
PART = 0.35  # share of a side to either side of its middle along which its profile is taken
WINDOW = 10e-3  # m
BESIDE = 1e-3  # m beyond a wire within which points felt belong to it


def is_hollow(views: list[SolidView], middle: Array, size: float) -> bool:
    """Whether a flat outline of some size, m, has no face: inside a wire the membrane hangs lower in the middle than near the wire."""
    found = []
    for view in views:
        away = np.hypot(*(view.points[:, :2] - middle).T)
        inner, outer = view.points[away < 0.3 * size, 2], view.points[(away > 0.6 * size) & (away < 0.8 * size), 2]
        if len(inner) > 20 and len(outer) > 20:
            found.append(float(np.quantile(outer, 0.8) - np.quantile(inner, 0.5) - 0.84 * view.noise))
    return bool(found) and float(np.median(found)) > HOLLOW


def wire_circle(rays: Rays, floor: float, wire: tuple[float, float]) -> dict[str, Dimension]:
    """Return the outer radius of a circle of wire, whose own radius is `wire` with its sd, m, and the height of its top."""
    moved = [inside_wire(bend, wire[0]) for bend in rays.bends]
    places = rays.places + np.array([m.shift for m in moved])[:, None] * rays.directions
    fitted = circle_outline(places)
    seen = circle_outline(rays.places).sizes[0]
    spread = float(np.std(np.hypot(*(places - fitted.middle).T))) / math.sqrt(len(moved) / 4)
    sd = math.hypot(math.hypot(spread, SHARED), wire[1])
    radius = fitted.sizes[0] + wire[0]
    return {"radius": Dimension(radius, sd, {"membrane": radius - seen}), "height": _height(rays.bends, floor)}


def wire_triangle(
    views: list[SolidView], outline: Fitted, floor: float, wire: tuple[float, float]
) -> dict[str, Dimension]:
    """Return the mean side of a triangle of wire, along the middle of the wire with sharp corners, and the height of its top.

    Raises
    ------
    IllConditioned
        A side is not seen.
    """
    found, bends, share = [], [], 0.0
    for k in range(3):
        angle = outline.heading + k * 2 * math.pi / 3
        outward = np.array([math.cos(angle), math.sin(angle)])
        side, seen, lean = _side(views, outline.middle, outward, outline.sizes[0], wire[0])
        found.append(side)
        bends += seen
        share += lean
    # The distances of any place from the sides of an equilateral triangle sum to its height.
    grow = 2 / math.sqrt(3)
    value, moved = (grow * sum(v) for v in ([d.value for d in found], [d.steps["membrane"] for d in found]))
    # One wire makes all sides, so that the errors by its radius add.
    sd = grow * math.hypot(wire[1] * share, *(d.sd for d in found), SHARED)
    return {"side": Dimension(value, sd, {"membrane": moved}), "height": _height(bends, floor)}


def _side(
    views: list[SolidView], middle: Array, outward: Array, away: float, wire: float
) -> tuple[Dimension, list[Bend], float]:
    """Return how far a side is from the middle, m, its bends, and its change over the change of the wire's radius."""
    found, bends, shares = [], [], []
    for view in views:
        profile = profile_of(
            view, middle, outward, PART * 2 * math.sqrt(3) * away / 2, away - 2 * WINDOW, away + 2 * WINDOW
        )
        try:
            bend = fit_bend(profile, away, reach=WINDOW)
        except IllConditioned:
            continue
        beyond = inside_wire(bend, wire)
        sd = math.hypot(math.hypot(bend.sd, beyond.sd), SHARED)
        found.append(Dimension(bend.place + beyond.shift, sd, {"membrane": beyond.shift}))
        bends.append(bend)
        shares.append(beyond.share)
    if not found:
        raise IllConditioned("no view shows the membrane on both sides of one of the wire's sides; press nearer to it")
    return pooled(found), bends, float(np.mean(shares))


def _height(bends: list[Bend], floor: float) -> Dimension:
    """Return the height of the wire's top, m: the height of the membrane where it bends."""
    surfaces = [b.surface for b in bends]
    sd = float(np.std(surfaces)) / math.sqrt(max(len(surfaces) / 4, 1.0))
    seen = float(np.median([b.height for b in bends]))
    value = float(np.median(surfaces))
    return Dimension(value, math.hypot(math.hypot(sd, SHARED), floor), {"membrane": value - seen})


def no_wire_there(solid: Solid, places: Array, radius: float) -> npt.NDArray[np.bool_]:
    """Return at which world places (n, 2), m, inside a shape of wire the membrane hangs; nowhere in one of another kind.

    Inside a triangle a membrane is as flat as on a face, so that only the shape shows it.
    """
    away = places - solid.middle[:2]
    if solid.kind == "wire_circle":
        return np.asarray(np.hypot(*away.T) < solid.dimensions["radius"].value - 2 * radius - BESIDE)
    if solid.kind == "wire_triangle":
        normals = solid.heading + np.arange(3) * 2 * math.pi / 3
        out = (away @ np.stack([np.cos(normals), np.sin(normals)])).max(axis=1)
        return np.asarray(out < solid.dimensions["side"].value / (2 * math.sqrt(3)) - radius - BESIDE)
    return np.zeros(len(places), dtype=bool)
