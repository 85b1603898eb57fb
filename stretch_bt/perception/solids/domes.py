"""Domes in any number, and points: tops that are round both ways."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.bend import LONGEST, fit_bend
from stretch_bt.perception.solids.crest import LAYER, LAYER_SD, PLAIN
from stretch_bt.perception.solids.profile import profile_of
from stretch_bt.perception.solids.result import Dimension, pooled
from stretch_bt.perception.solids.views import SolidView

__all__ = ["Dome", "domes", "domes_of", "evidence_of_domes", "point", "radii_of"]

Array = npt.NDArray[np.float64]

BAND = 1.5e-3  # m to either side of a line through a peak
REACH = 7e-3  # m
PATCH = 3e-3  # m round a peak over which its height is taken
MOST = 12e-3  # m from a peak to the hand within which a view shows the length over which the membrane bends
ABOVE = 0.3e-3  # m above the lowest within which a view still lies on the peak: a membrane that hangs over it is higher
ONE = 0.75  # of a dome's height, nearer than which another hump is of the same
BLUNT = 30.0  # 1/m, least curvature for a step: along a ridge of noise it would be endless
CLIMBS, CELL = 5, 0.2e-3  # steps from a hump to its peak, and m of a step that is the last
SHARED = 0.15e-3  # m
RADIUS_SD = 0.35  # of a radius that a light touch of a round top shows
STANDS = (1.0, 0.5)  # radius over height of the round bodies that stand on the table: a half-sphere, and a whole one
NEAR_SD = 0.1  # of the logarithm of the radius seen, over that of a body which stands so
OTHER = 3.5  # of these deviations, from which another body is as likely as one that stands so


@dataclass(frozen=True, slots=True)
class Dome:
    """A peak: where (2,), m, its height, the radius of curvature that shows there, m, and the length over which the membrane bends, m."""

    middle: Array
    height: Dimension
    radius: float
    layer: float


def domes_of(views: list[SolidView], peaks: list[Array]) -> list[Dome]:
    """Return the dome at each peak that a view shows.

    Raises
    ------
    IllConditioned
        There is no peak, or none that a view shows.
    """
    found: list[Dome] = []
    for peak in peaks:
        with suppress(IllConditioned):
            dome = _dome(views, peak)
            if all(np.hypot(*(dome.middle - other.middle)) > ONE * other.height.value for other in found):
                found.append(dome)
    if not found:
        raise IllConditioned("no view shows a peak; press over the top of the object")
    return found


def _dome(views: list[SolidView], hump: Array) -> Dome:
    peak, height, lying = _climbed(views, hump)
    nearest = sorted(views, key=lambda v: float(np.hypot(*(v.hand[:2] - peak))))
    close = [v for v in nearest if np.hypot(*(v.hand[:2] - peak)) < MOST] or nearest[:1]
    layers = []
    for view in close:
        for along in np.eye(2):
            try:
                bend = fit_bend(profile_of(view, peak, along, BAND, -2 * REACH, 2 * REACH), 0.0, reach=REACH)
            except IllConditioned:  # it is too round to be one
                layers.append(LONGEST)
            else:
                layers.append(bend.length)
    return Dome(peak, height, float(np.median(lying)), float(np.median(layers)))


def _climbed(views: list[SolidView], hump: Array) -> tuple[Array, Dimension, list[float]]:
    """Return the place of the peak of a hump, whose most curved place is beside it, with its height and the radii of curvature there."""
    peak, known = hump, _lying(views, hump)
    for _ in range(CLIMBS):
        way = known[2] * min(1.0, PATCH / max(float(np.hypot(*known[2])), 1e-9))
        try:
            peak, known = peak + way, _lying(views, peak + way)
        except IllConditioned:
            break
        if np.hypot(*way) < CELL:
            break
    return peak, known[0], known[1]


def _lying(views: list[SolidView], peak: Array) -> tuple[Dimension, list[float], Array]:
    """Return the height of a peak, the radius of curvature, m, that each view shows, and the way to the peak (2,), m, by the views that lie on it."""
    tops, radii, ways = [], [], []
    for view in views:
        try:
            height, curvatures, way = _vertex(view, peak)
        except IllConditioned:
            continue
        tops.append(Dimension(height, max(view.noise / 2, view.shared, 1e-5), {}))
        radii.append(1 / max(float(np.mean(curvatures)), 1.0))
        ways.append(way)
    if not tops:
        raise IllConditioned("no view shows the peak; press over the top of the object")
    lowest = min(top.value for top in tops)
    lies = [top.value < lowest + ABOVE for top in tops]
    known = pooled([top for top, on in zip(tops, lies, strict=True) if on])
    way = np.median([way for way, on in zip(ways, lies, strict=True) if on], axis=0)
    return known, [radius for radius, on in zip(radii, lies, strict=True) if on], way


def _vertex(view: SolidView, peak: Array) -> tuple[float, tuple[float, float], Array]:
    """Return the height of a quadric's highest point near a peak, m, its curvatures, 1/m, and the way to that point (2,), m."""
    away = view.points[:, :2] - peak
    near = np.hypot(*away.T) < PATCH
    if near.sum() < 30:
        raise IllConditioned("the view does not show the peak; press over the top of the object")
    (x, y), z = away[near].T, view.points[near, 2]
    design = np.column_stack([np.ones_like(x), x, y, x * x / 2, x * y, y * y / 2])
    fit = np.linalg.lstsq(design, z, rcond=None)[0]
    bend = -np.array([[fit[3], fit[4]], [fit[4], fit[5]]])
    (small, large), axes = np.linalg.eigh(bend)
    way = axes @ ((fit[1:3] @ axes) / np.maximum([small, large], BLUNT))
    rise = min(0.5 * float(fit[1:3] @ way), 0.5e-3) if small > 0 else 0.0
    return float(fit[0]) + rise, (max(float(small), 0.0), float(large)), way


def evidence_of_domes(found: list[Dome]) -> dict[str, float]:
    """Return the evidence, nats, for half-spheres or spheres on the table and for points, on the mean over all."""
    over = [[math.log(d.radius / max(share * d.height.value, 1e-4)) for share in STANDS] for d in found]
    off = [0.5 * min(min(abs(o) for o in one) ** 2 / RADIUS_SD**2, 2 * PLAIN) for one in over]
    sharp = [0.5 * (max(d.layer - LAYER, 0.0) / LAYER_SD) ** 2 for d in found]
    return {"domes": -float(np.mean(off)), "point": -float(np.mean(sharp)) - 1.0 * (len(found) - 1)}


def domes(found: list[Dome], floor: float) -> dict[str, Dimension]:
    """Return the height of the highest dome and the radius of each, the largest first.

    A half-sphere on the table is as high as its radius, a whole one twice that, and the curvature of its top must agree with one of them.
    """
    ordered = sorted(radii_of(found, floor), key=lambda d: -d.value)
    named = {f"radius_{k}": radius for k, radius in enumerate(ordered, 1)}
    return {**named, "radius": ordered[0], "height": max(_heights(found, floor), key=lambda d: d.value)}


def radii_of(found: list[Dome], floor: float) -> list[Dimension]:
    """Return the radius of each dome, by the curvature of its top and its height."""
    return [_radius(d.radius, height) for d, height in zip(found, _heights(found, floor), strict=True)]


def _radius(seen: float, height: Dimension) -> Dimension:
    """Return the radius of a dome from the radius that its top shows, m, and its height.

    It is the mean over a half-sphere, a whole one and a body of another shape, by how well each agrees with what is seen, so that its
    deviation includes that it may be another. A membrane that touches a half-sphere lightly shows a larger radius.
    """
    top = max(height.value, 1e-4)
    shown, seen = seen, min(seen, top)
    known = [(share * top, share * height.sd, math.log(seen / (share * top)) / NEAR_SD) for share in STANDS]
    known.append((seen, RADIUS_SD * seen, OTHER))
    least = min(abs(off) for *_, off in known)
    weights = np.array([math.exp((least**2 - off**2) / 2) for *_, off in known])
    values, sds = np.array([value for value, *_ in known]), np.array([sd for _, sd, _ in known])
    weights /= weights.sum()
    value = float(weights @ values)
    return Dimension(value, math.sqrt(float(weights @ (sds**2 + (values - value) ** 2))), {"table": value - shown})


def _heights(found: list[Dome], floor: float) -> list[Dimension]:
    shared = math.hypot(floor, SHARED)
    return [Dimension(d.height.value, math.hypot(d.height.sd, shared), {}) for d in found]


def point(found: list[Dome], floor: float) -> dict[str, Dimension]:
    """Return the height of a point, as of a pyramid."""
    top = found[0].height
    return {"height": Dimension(top.value, math.hypot(top.sd, math.hypot(floor, SHARED)), {})}
