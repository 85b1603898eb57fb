"""A block, a bridge or a disc: a flat top whose sides the membrane bends over."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.bend import fit_bend
from stretch_bt.perception.solids.conformity import beyond_edge
from stretch_bt.perception.solids.outline import Fitted, Rays
from stretch_bt.perception.solids.profile import profile_of
from stretch_bt.perception.solids.result import Dimension, pooled
from stretch_bt.perception.solids.views import View

__all__ = ["block", "disc", "flat_height"]

Array = npt.NDArray[np.float64]

INNER = 0.6  # share of a side along which its profile is taken: at corners the membrane falls off to two sides
SHARED = 0.1e-3  # m by which all bends of a side err alike
WINDOW = 12e-3  # m to either side of a bend


def block(views: list[View], outline: Fitted, floor: float, fillet: tuple[float, float]) -> dict[str, Dimension]:
    """Return length, width and height of a flat top with a rectangular outline, and its heading in `outline`.

    Raises
    ------
    IllConditioned
        No view shows one of its sides.
    """
    c, s = math.cos(outline.heading), math.sin(outline.heading)
    axes, half = np.array([[c, s], [-s, c]]), outline.sizes
    spans = [_span(views, outline.middle, axes[k], half[k], half[1 - k], fillet) for k in (0, 1)]
    length, width = sorted(spans, key=lambda d: -d.value)
    inside = [_inside(view, outline.middle, axes, half) for view in views]
    return {"length": length, "width": width, "height": flat_height(views, inside, floor)}


def _span(
    views: list[View], middle: Array, along: Array, half: float, across: float, fillet: tuple[float, float]
) -> Dimension:
    """Return the distance of two opposite sides, m."""
    ends = [_side(views, middle, sign * along, half, across, fillet) for sign in (1.0, -1.0)]
    value, moved = sum(e.value for e in ends), sum(e.steps["membrane"] for e in ends)
    # Both sides have edges of the same radius, so that their errors add.
    common = sum(_fillet_sd(e, fillet) for e in ends)
    own = math.hypot(*(e.sd for e in ends))
    return Dimension(value, math.hypot(own, common), {"membrane": moved})


def _fillet_sd(end: Dimension, fillet: tuple[float, float]) -> float:
    return min(fillet[1], fillet[1] * end.steps["membrane"] / max(fillet[0], 1e-6))


def _side(
    views: list[View], middle: Array, outward: Array, half: float, across: float, fillet: tuple[float, float]
) -> Dimension:
    """Return how far a side is from the middle, m, as a mean over the views that show it."""
    found = []
    for view in views:
        window = (half - WINDOW - 2e-3, half + WINDOW + 2e-3)
        profile = profile_of(view, middle, outward, INNER * across, *window)
        try:
            bend = fit_bend(profile, half, reach=min(WINDOW, 0.8 * half))
        except IllConditioned:
            continue
        if abs(bend.place - half) < 4e-3 and abs(bend.near) < 0.15:
            beyond = beyond_edge(bend, fillet[0], 0.0)
            found.append(
                Dimension(bend.place + beyond.shift, math.hypot(bend.sd, beyond.sd), {"membrane": beyond.shift})
            )
    if not found:
        raise IllConditioned(
            "no view shows the membrane on both sides of one of the edges of the top; press nearer to it"
        )
    return pooled(found, SHARED)


def disc(
    views: list[View], outline: Fitted, rays: Rays, floor: float, fillet: tuple[float, float]
) -> dict[str, Dimension]:
    """Return radius, diameter and height of a flat top with a round outline."""
    beyond = [beyond_edge(bend, fillet[0], 0.0) for bend in rays.bends]
    moved = float(np.mean([b.shift for b in beyond]))
    spread = float(np.std(np.hypot(*(rays.places - outline.middle).T))) / math.sqrt(len(beyond) / 4)
    sd = math.hypot(spread, math.hypot(SHARED, fillet[1] * moved / max(fillet[0], 1e-6)))
    radius = Dimension(outline.sizes[0] + moved, sd, {"membrane": moved})
    inside = [np.hypot(*(v.points[:, :2] - outline.middle).T) < INNER * outline.sizes[0] for v in views]
    diameter = Dimension(2 * radius.value, 2 * sd, {"membrane": 2 * moved})
    return {"radius": radius, "diameter": diameter, "height": flat_height(views, inside, floor)}


def flat_height(views: list[View], inside: list[npt.NDArray[np.bool_]], floor: float) -> Dimension:
    """Return the height of a flat top above the table, m, from the points inside its outline."""
    found = []
    for view, within in zip(views, inside, strict=True):
        z = view.points[within, 2]
        if len(z) > 20:
            spread = float(np.std(z)) / math.sqrt(len(z) / 100)
            found.append(Dimension(float(np.median(z)), max(view.shared, spread, 1e-6), {}))
    if not found:
        raise IllConditioned("no view shows the top; press over the middle of the object")
    return pooled(found, floor)


def _inside(view: View, middle: Array, axes: Array, half: tuple[float, ...]) -> npt.NDArray[np.bool_]:
    away = np.abs((view.points[:, :2] - middle) @ axes.T)
    return np.asarray((away < INNER * np.array(half)).all(axis=1))
