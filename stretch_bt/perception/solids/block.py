"""A block, a bridge or a disc: a flat top whose sides the membrane bends over."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.corner import Corner, fit_corner
from stretch_bt.perception.solids.outline import RAYS, Fitted, nearest_views
from stretch_bt.perception.solids.profile import profile_of
from stretch_bt.perception.solids.result import Dimension, pooled
from stretch_bt.perception.solids.views import SolidView

__all__ = ["block", "disc"]

Array = npt.NDArray[np.float64]

INNER = 0.6  # share of a side along which its profile is taken: at corners the membrane falls off to two sides
SHARED = 0.1e-3  # m, error that all bends of a side share
WINDOW = 12e-3  # m to either side of a bend
NEAR = 4e-3  # m from the outline within which an edge is sought
BAND = 1.5e-3  # m to either side of a ray
FEWEST = 10  # edges around a disc


def block(views: list[SolidView], outline: Fitted, floor: float, fillet: tuple[float, float]) -> dict[str, Dimension]:
    """Return length, width and height of a flat top with a rectangular outline, and its heading in `outline`.

    Raises
    ------
    IllConditioned
        No view shows one of its sides.
    """
    c, s = math.cos(outline.heading), math.sin(outline.heading)
    axes, half = np.array([[c, s], [-s, c]]), outline.sizes
    ends = [
        [_edges(views, outline.middle, sign * axes[k], half[k], half[1 - k], fillet) for sign in (1.0, -1.0)]
        for k in (0, 1)
    ]
    length, width = sorted((_span(pair, fillet) for pair in ends), key=lambda d: -d.value)
    return {"length": length, "width": width, "height": _height([e for pair in ends for e in pair], floor, fillet)}


def _span(ends: list[list[Corner]], fillet: tuple[float, float]) -> Dimension:
    """Return the distance of two opposite sides, m."""
    sides = [pooled([corner.side for corner in end], SHARED) for end in ends]
    value, moved = sum(side.value for side in sides), sum(side.steps["membrane"] for side in sides)
    # Both sides have edges of the same radius, so that their errors add.
    common = sum(fillet[1] * _mean([corner.side_share for corner in end]) for end in ends)
    return Dimension(value, math.hypot(common, *(side.sd for side in sides)), {"membrane": moved})


def _edges(
    views: list[SolidView], middle: Array, outward: Array, half: float, across: float, fillet: tuple[float, float]
) -> list[Corner]:
    """Return a side as the views show it, from the middle."""
    found = []
    for view in views:
        window = (half - WINDOW - 2e-3, half + WINDOW + 2e-3)
        profile = profile_of(view, middle, outward, INNER * across, *window)
        with suppress(IllConditioned):
            corner = fit_corner(profile, half, fillet[0], reach=min(WINDOW, 0.8 * half))
            if abs(corner.side.value - half) < NEAR:
                found.append(corner)
    if not found:
        raise IllConditioned(
            "no view shows the membrane on both sides of one of the edges of the top; press nearer to it"
        )
    return found


def _height(ends: list[list[Corner]], floor: float, fillet: tuple[float, float]) -> Dimension:
    """Return the height of a flat top above the table, m: the height of its edges, where a membrane lifts off it."""
    found = pooled([pooled([corner.top for corner in end]) for end in ends])
    common = fillet[1] * _mean([corner.top_share for end in ends for corner in end])
    return Dimension(found.value, math.hypot(found.sd, common, floor, SHARED), found.steps)


def disc(views: list[SolidView], outline: Fitted, floor: float, fillet: tuple[float, float]) -> dict[str, Dimension]:
    """Return radius, diameter and height of a flat top with a round outline.

    Raises
    ------
    IllConditioned
        Too little of its edge is seen.
    """
    found = list(_around(views, outline, fillet))
    if len(found) < FEWEST:
        raise IllConditioned("too little of the edge of a disc is seen; press nearer to its middle")
    sides = np.array([corner.side.value for corner in found])
    moved = _mean([corner.side.steps["membrane"] for corner in found])
    spread = float(np.std(sides)) / math.sqrt(len(sides) / 4)
    common = fillet[1] * _mean([corner.side_share for corner in found])
    radius = Dimension(float(sides.mean()), math.hypot(spread, SHARED, common), {"membrane": moved})
    diameter = Dimension(2 * radius.value, 2 * radius.sd, {"membrane": 2 * moved})
    return {"radius": radius, "diameter": diameter, "height": _height([found], floor, fillet)}


def _around(views: list[SolidView], outline: Fitted, fillet: tuple[float, float]) -> Iterator[Corner]:
    """Yield the edge of a disc all around, as the views nearest to it show it."""
    radius = outline.sizes[0]
    for view in nearest_views(views, outline.middle):
        for angle in np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False):
            along = np.array([np.cos(angle), np.sin(angle)])
            profile = profile_of(view, outline.middle, along, BAND, radius - WINDOW, radius + WINDOW + 2e-3)
            with suppress(IllConditioned):
                corner = fit_corner(profile, radius, fillet[0], reach=min(WINDOW, 0.8 * radius))
                if abs(corner.side.value - radius) < NEAR:
                    yield corner


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))
