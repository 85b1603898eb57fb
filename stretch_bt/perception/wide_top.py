"""Height of a top by discs wider than the contact, where noise is alike over much of that."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.top import Points, Top, disc_of
from stretch_bt.units import Estimate

__all__ = ["by_wide_discs", "disc_top"]

Array = npt.NDArray[np.float64]

RADII = (1.0, 1.5, 2.0, 2.5, 3.0)  # radius of the disc over the contact's
# The skirt within such a disc makes its quadratic's vertex lie below the top, by a share of the height that goes with how pointed the disc
# is: `Top.tip` over the disc's fall. By presses without noise of balls, caps, discs, blocks, tips, cones and light ones, in discs about what
# noise makes a contact (`python benchmarks/height_bend.py`): how pointed these are, its standard deviation; the share for 1, for
# how pointed it is and for its square; the standard deviation of the share.
POINTED, SPREAD = (-0.20, 0.10, 0.33, 0.48, 0.58), (0.57, 0.40, 0.28, 0.21, 0.16)
BELOW = ((-0.005, -0.020, -0.052, -0.090, -0.100), (0.18, 0.23, 0.25, 0.27, 0.28), (0.18, 0.21, 0.33, 0.43, 0.44))
OFF = (0.025, 0.040, 0.051, 0.064, 0.085)
MOST_POINTED = 1.0  # either way
PATCHES = 5.0  # independent values: a wide disc must hold so many, and noise chose a contact that holds fewer
# Standard deviations by which a disc's vertex may lie below the contact's own: beyond, the top is sharper than such a disc can show.
SHARP = 2.5
# factor on the standard deviation that the surest of some states: it is taken because its own noise made it look sure
SURER = 1.15
# share of the difference between a disc and the contact alone, which is an error of the one or the other: noise chose the contact, and
# the skirt within the disc is unlike the shapes from which OFF is
HALFWAY = 0.5
# error of the height of a contact that noise chose, in standard deviations of shared noise
CHOSEN = 0.6
CLEAR = 0.03  # share of the depth: below such an error no wider disc can give a better height
SMALL = 3.0  # times the shared noise: where this is below CLEAR, noise does not choose what is taken for contact
LEAST_POINTS = 30
ROUGHLY = 1500  # points that show about where a top has its vertex


class WideTop(NamedTuple):
    """The height by a wide disc, m, and its standard deviation, m, if the disc were known to be as pointed as it looks."""

    height: Estimate
    usual_sd: float


def by_wide_discs(top: Estimate, contact: Points, around: Points) -> Estimate:
    """Return the surest height of a contact's top, m, by the contact alone or by a wider disc."""
    assert contact.noise is not None
    noise, clear = contact.noise, CLEAR * abs(top.value)
    if SMALL * noise.shared_sd >= clear and _pixels(contact) < PATCHES * noise.shared_area:
        top = Estimate(top.value, math.hypot(top.sd, CHOSEN * noise.shared_sd))
    if top.sd < clear:
        return top
    best = _surest(top, contact, around)
    apart = HALFWAY * (best.value - top.value)  # 0 where the contact alone is the surest
    return Estimate(best.value, math.hypot(best.sd, apart))


def _surest(alone: Estimate, contact: Points, around: Points) -> Estimate:
    """Return the surest of the height by a contact alone, m, and the heights by wider discs; a little less sure where there are some."""
    start, _, radius = disc_of(contact.cloud)
    pixel = math.sqrt(math.pi / _pixels(contact)) * radius  # m
    assert contact.noise is not None
    least = math.sqrt(PATCHES * contact.noise.area / math.pi) * pixel
    discs = {max(share * radius, least) for share in RADII}
    best, surer = alone, 1.0
    for wide in sorted(disc for disc in discs if disc <= RADII[-1] * radius):
        if best.sd < float(np.interp(wide / radius, RADII, OFF)) * abs(best.value):
            break  # the skirt's error grows with the disc
        try:
            found = _of_disc(around, start, wide, wide / radius)
        except (IllConditioned, np.linalg.LinAlgError):
            continue
        if found is None or found.height.value < alone.value - SHARP * math.hypot(found.usual_sd, alone.sd):
            continue
        surer = SURER
        if found.height.sd < best.sd:
            best = found.height
    return Estimate(best.value, surer * best.sd)


def _pixels(contact: Points) -> int:
    """Return how many pixels a contact covers; its points may be of every second, third ... row and column alone."""
    return len(contact) * contact.every**2


def disc_top(around: Points, middle: Array, radius: float) -> Top | None:
    """Return the quadratic over a disc of a radius, m, about the top near a place (2,), m; None where the disc shows no top."""
    for most in (ROUGHLY, around.places.size):
        x, y = around.cloud[0] - middle[0], around.cloud[1] - middle[1]
        near = np.flatnonzero(x * x + y * y <= radius * radius)
        if near.size < LEAST_POINTS:
            return None
        top = Top(around.at(near[:: -(-near.size // most)]), middle, even=False)
        if not top.is_convex:
            return None
        middle = top.vertex(0.5 * radius)
    return top


def _of_disc(around: Points, middle: Array, radius: float, share: float) -> WideTop | None:
    """Return the height by the disc of a radius, m, which is such a share of the contact's; None where it shows no top."""
    top = disc_top(around, middle, radius)
    if top is None:
        return None
    vertex, below = top.estimate(0.5 * radius), _below(top.tip(0.5 * radius), top.sag, share)
    left = 1.0 - below.value
    height, off = vertex.value / left, float(np.interp(share, RADII, OFF))
    sd, usual = (math.hypot(vertex.sd, part * height) / left for part in (below.sd, off))
    return WideTop(Estimate(height, sd), usual)


def _below(tip: Estimate, fall: Estimate, share: float) -> Estimate:
    """Return the share of the height by which the vertex over a disc lies below the top, by the disc's tip, m, and its fall, m."""
    usual, spread, off, *law = (float(np.interp(share, RADII, row)) for row in (POINTED, SPREAD, OFF, *BELOW))
    seen = min(max(tip.value / fall.value, -MOST_POINTED), MOST_POINTED)
    weight = spread**2 / (spread**2 + (math.hypot(tip.sd, seen * fall.sd) / fall.value) ** 2)
    pointed = usual + weight * (seen - usual)
    slope = law[1] + 2.0 * law[2] * pointed
    share_sd = slope * spread * math.sqrt(max(1.0 - weight, 0.0))
    return Estimate(law[0] + law[1] * pointed + law[2] * pointed**2, math.hypot(share_sd, off))
