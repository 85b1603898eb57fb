"""The outline of a flat top or a wire by the bends all around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.bend import CONVERGED, Bend, search_bend
from stretch_bt.perception.solids.profile import profile_of
from stretch_bt.perception.solids.views import SolidView

__all__ = [
    "RAYS",
    "Fitted",
    "Rays",
    "circle_outline",
    "nearest_views",
    "outlines",
    "polygon_outline",
    "rays_of",
    "rectangle_outline",
]

Array = npt.NDArray[np.float64]

RAYS = 24
BAND = 1.5e-3  # m to either side of a ray
NEAREST, FARTHEST = 4e-3, 45e-3  # m from the middle
OFF = 0.5e-3  # m, typical distance of bends from the outline of a shape that fits
FEWEST = 10


@dataclass(frozen=True, slots=True)
class Rays:
    """Bends seen along rays from places inside: where each is (n, 2), m, its bend and its direction (n, 2)."""

    places: Array
    directions: Array
    bends: list[Bend]


@dataclass(frozen=True, slots=True)
class Fitted:
    """An outline: `name`, middle (2,), m, sizes, m, heading, rad, and its evidence, nats."""

    name: str
    middle: Array
    sizes: tuple[float, ...]
    heading: float
    evidence: float


def rays_of(views: list[SolidView], middle: Array, reach: float) -> Rays:
    """Return the bends around a middle (2,), m, by the views whose hands stood nearest to it; `reach`, m, is how far out they may be.

    Raises
    ------
    IllConditioned
        Too few are seen.
    """
    places, directions, bends = [], [], []
    for view in nearest_views(views, middle):
        for angle in np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False):
            along = np.array([np.cos(angle), np.sin(angle)])
            profile = profile_of(view, middle, along, BAND, -FARTHEST / 2, FARTHEST + 20e-3)
            try:
                bend = search_bend(profile, NEAREST, min(reach, FARTHEST))
            except IllConditioned:
                continue
            places.append(middle + bend.place * along)
            directions.append(along)
            bends.append(bend)
    if len(places) < FEWEST:
        raise IllConditioned(
            f"the outline of the top shows along {len(places)} of {RAYS} directions only; press at the sides that no view shows"
        )
    return Rays(np.array(places), np.array(directions), bends)


def nearest_views(views: list[SolidView], middle: Array, most: int = 3) -> list[SolidView]:
    """Return the views whose hands stood nearest to a middle (2,), m."""
    return sorted(views, key=lambda v: float(np.hypot(*(v.hand[:2] - middle))))[:most]


def outlines(places: Array) -> list[Fitted]:
    """Return circle, rectangle and triangle of equal sides through places (n, 2), m, the one with most evidence first."""
    found = [circle_outline(places), rectangle_outline(places), polygon_outline(places, 3)]
    return sorted(found, key=lambda f: -f.evidence)


def circle_outline(places: Array) -> Fitted:
    """Return the circle through places (n, 2), m; its size is the radius."""
    middle = places.mean(axis=0)

    def off(q: Array) -> Array:
        return np.asarray(np.hypot(*(places - q[:2]).T) - q[2])

    start = np.array([*middle, np.hypot(*(places - middle).T).mean()])
    return _settled("circle", off, [start], slice(2, 3), None, len(places))


def rectangle_outline(places: Array) -> Fitted:
    """Return the rectangle through places (n, 2), m; its sizes are the halves of its sides, the first along its heading."""
    middle = (places.min(axis=0) + places.max(axis=0)) / 2

    def off(q: Array) -> Array:
        x, y = _turned(places - q[:2], q[4])
        outside = np.abs(np.column_stack([x, y])) - q[2:4]
        return np.asarray(np.where((outside > 0).all(axis=1), np.hypot(*outside.T), outside.max(axis=1)))

    starts = []
    for angle in np.radians([0.0, 22.5, 45.0, 67.5]):
        half = np.abs(np.array(_turned(places - middle, angle))).max(axis=1)
        starts.append(np.array([*middle, *half, angle]))
    return _settled("rectangle", off, starts, slice(2, 4), 4, len(places))


def polygon_outline(places: Array, sides: int) -> Fitted:
    """Return the regular polygon through places (n, 2), m; its size is the radius of the circle inside, its heading a normal's."""
    middle = places.mean(axis=0)

    def off(q: Array) -> Array:
        normals = q[3] + np.arange(sides) * 2 * np.pi / sides
        away = (places - q[:2]) @ np.stack([np.cos(normals), np.sin(normals)])
        return np.asarray(away.max(axis=1) - q[2])

    size = np.quantile(np.hypot(*(places - middle).T), 0.2)
    starts = [np.array([*middle, size, angle]) for angle in np.linspace(0.0, 2 * np.pi / sides, 4, endpoint=False)]
    return _settled("triangle", off, starts, slice(2, 3), 3, len(places))


def _turned(places: Array, angle: float) -> tuple[Array, Array]:
    c, s = np.cos(angle), np.sin(angle)
    return places[:, 0] * c + places[:, 1] * s, places[:, 1] * c - places[:, 0] * s


def _settled(
    name: str, off: Callable[[Array], Array], starts: list[Array], sizes: slice, heading: int | None, count: int
) -> Fitted:
    """Return the outline that lies nearest to places, from the best of several starts."""
    from scipy.optimize import least_squares

    def pulls(q: Array) -> Array:
        return off(q) / OFF

    def fit(start: Array, **options: Any) -> Any:
        return least_squares(pulls, start, loss="soft_l1", x_scale=np.maximum(np.abs(start), 1e-3), **options)

    nearest = min(map(fit, starts), key=lambda f: float(f.cost))
    best = fit(nearest.x, jac="3-point", **CONVERGED)
    q: Array = np.asarray(best.x)
    # neighbouring rays err alike
    evidence = -float(best.cost) / 2 - 0.5 * len(q) * float(np.log(count))
    turn = 0.0 if heading is None else float(q[heading])
    return Fitted(name, q[:2], tuple(float(v) for v in q[sizes]), turn, evidence)
