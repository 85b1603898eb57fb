"""Height of one top by a disc of its points: the vertex of a quadratic on a curved top, a robust mean on a flat one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.perhaps import either, perhaps_above
from stretch_bt.perception.pointed import FAINT_SHARPNESS, TIPS, of_tip, tip_odds
from stretch_bt.perception.robust import quantile
from stretch_bt.perception.steps import shared_step
from stretch_bt.perception.top import Points, Top, disc_of, settled
from stretch_bt.units import Estimate

__all__ = ["LEAST_POINTS", "DiscTop", "top_by_discs"]

Array = npt.NDArray[np.float64]

RIM = 0.75  # share of the contact's radius that the membrane's bend at the rim leaves alone
HIGH = 0.1  # share of the points that are the highest
AROUND = 1.5  # radii of those within which a top is sought
BEND = 0.35  # share of the radius of curvature within which a quadratic is a sphere to a thousandth of the radius
# A top that is not clearly curved is as likely flat as to fall, within RIM, by anything up to DEEPEST of its depth. Tops with the same fall differ
# in height, so that the deviation of the fall is multiplied by VARIED, fitted to tops in seven noises.
DEEPEST, VARIED = 0.6, 1.5
ROUGHLY = 0.4  # of the curvature by a disc that may hold skirt: its standard deviation
BLUNT = 0.3  # share of a tip above the vertex of a wide disc, by which it may be blunter than a cone, one standard deviation
AS_SHARP = 1.0  # odds that a tip is as sharp as a wide disc says, where no fine one shows it
LEAST_POINTS = 12


class DiscTop(NamedTuple):
    """Height of a top, m, and whether it is clearly curved."""

    height: Estimate
    is_curved: bool


def top_by_discs(points: Points, known: Estimate | None = None, by_half: float = 1.0) -> DiscTop:
    """Return the top from a disc that the membrane's bend at the rim leaves alone, by its curvature, 1/m, too where that is `known`.

    The standard deviation includes `by_half` times the difference from the height of a disc half as wide.
    """
    cloud = points.cloud
    middle, away, radius = disc_of(cloud)
    reach = RIM * radius
    near = _disc(points, away, reach)
    free = Top(near, middle, even=False)
    top = free.bent(known)
    odds = TIPS if top is free else 0.0  # a top of known curvature is no tip
    if not top.is_curved:
        top, reach = _of_highest(points, top, reach, known)
    if top.is_curved:
        within = min(reach, max(BEND / top.curvature, 0.3 * radius))
        middle = top.vertex(radius)
        wide, before, near, shown = top, near, _disc(points, _away(cloud, middle), within), True
        if not np.array_equal(before.places, near.places):
            odds = tip_odds(top.tip(radius), top.fall, odds)
            top, shown = _finer(top, near, middle, known)
        found = _vertex(top, wide, shown, radius, odds)
        unlike = by_half * _unlike_half(found, near, middle, radius, known, odds)
        return DiscTop(Estimate(found.value, math.hypot(found.sd, unlike, shared_step(points.step, top.sd))), shown)
    top, flat = Top(near, middle, even=True), _flat(near)
    return DiscTop(_faint(top, Estimate(flat.value, math.hypot(flat.sd, top.misfit)), odds), False)


def _vertex(fine: Top, wide: Top, shown: bool, radius: float, odds: float) -> Estimate:
    """Return the height of a curved top, m, by a fine disc and a wide one, and the odds that it is a tip before the fine one is seen.

    Where a fine disc has not `shown` any curvature, a tip may be as blunt as the fine disc is round, or as sharp as the wide one says.
    """
    vertex = fine.estimate(radius)
    if odds == 0.0:
        return vertex
    seen = fine.tip(radius)
    blunt = _of_tip(vertex, of_tip(seen, fine.fall), 0.0)
    sharp = _of_tip(wide.estimate(radius), of_tip(wide.tip(radius), wide.fall), BLUNT)
    tip = min(blunt, sharp, key=lambda height: height.sd) if shown else either(AS_SHARP, sharp, blunt)
    return either(tip_odds(seen, fine.fall, odds), tip, vertex)


def _of_tip(vertex: Estimate, above: Estimate, blunt: float) -> Estimate:
    """Return the height of a tip, m, that may be lower by a share of what stands above the vertex."""
    return Estimate(vertex.value + above.value, math.hypot(vertex.sd, above.sd, blunt * above.value))


def _finer(wide: Top, near: Points, middle: Array, known: Estimate | None) -> tuple[Top, bool]:
    """Return the top of a disc near the middle (2,), and whether it shows a curvature; if not, with that of a wider disc, which may hold skirt."""
    top = Top(near, middle, even=False).bent(known)
    if top.is_curved:
        return top, True
    bent = top.bent(Estimate(wide.curvature, math.hypot(wide.curvature_sd, ROUGHLY * wide.curvature)))
    return (bent if bent.is_convex else wide), False


def _unlike_half(
    found: Estimate, near: Points, middle: Array, radius: float, known: Estimate | None, odds: float
) -> float:
    """Return the difference, m, of the heights from a disc and from its inner half, beyond what noise explains (Hausman, 1978).

    Then the disc holds skirt, which no quadratic follows.
    """
    away = _away(near.cloud, middle)
    inner = np.flatnonzero(away <= 0.5 * float(away.max()))
    if inner.size < LEAST_POINTS:
        return 0.0
    half = Top(near.at(inner), middle, even=False).bent(known)
    if not half.is_curved:
        return 0.0
    other = _vertex(half, half, True, radius, odds)
    by_chance = max(other.sd**2 - found.sd**2, 0.0)
    return math.sqrt(max((other.value - found.value) ** 2 - by_chance, 0.0))


def _of_highest(points: Points, top: Top, reach: float, known: Estimate | None) -> tuple[Top, float]:
    """Return the top about the highest points, and its reach, where it is clearly curved and much smaller; else as given.

    Where part of the skirt was taken for contact, the middle of all points lies beside the top. On a flat face the highest
    points lie anywhere.
    """
    cloud = points.cloud
    high = cloud[:, cloud[2] > quantile(cloud[2], 1.0 - HIGH)]
    if high.shape[1] < LEAST_POINTS:
        return top, reach
    middle = np.array([quantile(high[0]), quantile(high[1])])
    within = AROUND * math.sqrt(2.0 * quantile(_away(high, middle)))
    if within > 0.7 * reach:
        return top, reach
    other = Top(_disc(points, _away(cloud, middle), within), middle, even=False).bent(known)
    return (other, within) if other.is_curved else (top, reach)


def _faint(top: Top, flat: Estimate, odds: float) -> Estimate:
    """Return the height of a top that is flat, or nearly so, by the odds that one that is not is a tip rather than round.

    Taken for flat, a faint cap comes out too low by half its sag, and a faint cone by more.
    """
    sag = Estimate(top.sag.value, VARIED * top.sag.sd)
    likely, seen = perhaps_above(sag, DEEPEST * abs(flat.value)), top.tip(0.0)
    sharp = of_tip(seen, likely.value, FAINT_SHARPNESS)
    tip = either(tip_odds(seen, likely.value, odds, FAINT_SHARPNESS), sharp, Estimate(0.0, 0.0))
    return Estimate(flat.value + 0.5 * likely.value + tip.value, math.hypot(flat.sd, 0.5 * likely.sd, tip.sd))


def _away(cloud: Array, middle: Array) -> Array:
    """Return the squared lateral distances (n,) of points from a place."""
    x, y = cloud[0] - middle[0], cloud[1] - middle[1]
    return np.asarray(x * x + y * y)


def _disc(points: Points, away: Array, radius: float) -> Points:
    """Return the points whose squared distance lies within a radius, or all where that leaves too few."""
    near = np.flatnonzero(away <= radius * radius)
    return points.at(near) if near.size >= LEAST_POINTS else points


def _flat(points: Points) -> Estimate:
    """Return Tukey's robust mean of heights that come in steps, m, and its standard deviation."""
    z, n = points.cloud[2], len(points)
    center, one = quantile(z), np.ones((1, n))
    q, sd = settled(one, z - center, points.step)
    own = sd * sd / n + float(points.shared(one)[0, 0]) / n**2
    return Estimate(center + float(q[0]), math.hypot(math.sqrt(own), points.step_error(sd)))
