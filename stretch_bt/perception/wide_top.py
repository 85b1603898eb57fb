"""Height of a top by discs wider than the contact, where noise is alike over much of that."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.top import Points, Top, disc_of
from stretch_bt.units import Estimate

__all__ = ["by_wide_discs"]

Array = npt.NDArray[np.float64]

RADII = (1.0, 1.5, 2.0, 2.5, 3.0)  # radius of the disc over the contact's
# The vertex over such a disc lies below the top by this share of the depth, and by this standard deviation of it, over presses of
# spheres, caps, discs and blocks without noise (`python -m benchmarks.height_noise --bend`): the skirt within it is no quadratic.
BELOW = (-0.004, -0.017, 0.010, 0.050, 0.110)
OFF = (0.012, 0.035, 0.055, 0.065, 0.070)
# Share of the sag within a disc by which its vertex lies below a tip, and the standard deviation of that, where the sag over the radius is the
# second of STEEP and more; below the first, the top is round (balls of R 0.5 to 6 mm, `python -m benchmarks.height_noise --shape "analytic tip"`)
TIP, STEEP = (0.25, 0.1, 0.0, 0.0, 0.0), (0.15, 0.3)
PATCHES = 5.0  # independent values that a disc must hold before its quadratic counts
# Standard deviations by which a disc's vertex may lie below the contact's own: beyond, the top is sharper than such a disc can show.
SHARP = 2.5
# factor on the standard deviation that the surest of some states: it is taken because its own noise made it look sure
SURER = 1.15
# share of the difference between a disc and the contact alone, which is an error of the one or the other: noise chose the contact, and
# the skirt within the disc is unlike the shapes from which OFF is
HALFWAY = 0.5
# error of the height, in standard deviations of shared noise, where the contact that this noise chose holds fewer than PATCHES such values
CHOSEN = 0.7
CLEAR = 0.03  # share of the depth: below such an error no wider disc can give a better height
SMALL = 3.0  # times the shared noise: where this is below CLEAR, noise does not choose what is taken for contact
LEAST_POINTS = 30
ROUGHLY = 1500  # points that show about where a top has its vertex


def by_wide_discs(top: Estimate, contact: Points, around: Points) -> Estimate:
    """Return the surest height of a contact's top, m, by the contact alone or by a wider disc."""
    assert contact.noise is not None
    faint = SMALL * contact.noise.shared_sd < CLEAR * abs(top.value)
    chosen = faint or _pixels(contact) >= PATCHES * contact.noise.shared_area
    if not chosen:
        top = Estimate(top.value, math.hypot(top.sd, CHOSEN * contact.noise.shared_sd))
    enough = faint or _pixels(contact) >= PATCHES * contact.noise.area
    if enough and top.sd < CLEAR * abs(top.value):
        return top
    best, tip = _surest(top if enough else None, top, contact, around)
    if best is None:
        return top
    apart = HALFWAY * (best.value - top.value)  # 0 where the contact alone is the surest
    return Estimate(best.value + tip, math.hypot(SURER * best.sd, apart, tip))


def _surest(best: Estimate | None, alone: Estimate, contact: Points, around: Points) -> tuple[Estimate | None, float]:
    """Return the surest of a height, m, and the heights by wider discs, None where there is none, and how far a tip may stand above it, m."""
    tip = 0.0
    start, _, radius = disc_of(contact.cloud)
    pixel = math.sqrt(math.pi / _pixels(contact)) * radius  # m
    assert contact.noise is not None
    least = math.sqrt(PATCHES * contact.noise.area / math.pi) * pixel
    discs = {max(share * radius, least) for share in RADII}
    for wide in sorted(disc for disc in discs if disc <= RADII[-1] * radius):
        if best is not None and best.sd < float(np.interp(wide / radius, RADII, OFF)) * abs(best.value):
            break  # the skirt's error grows with the disc
        try:
            found = _of_disc(around, start, wide, wide / radius)
        except (IllConditioned, np.linalg.LinAlgError):
            continue
        if found is None or found[0].value < alone.value - SHARP * math.hypot(found[0].sd, alone.sd):
            continue
        if best is None or found[0].sd < best.sd:
            best, tip = found
    return best, tip


def _pixels(contact: Points) -> int:
    """Return how many pixels a contact covers; its points may be of every second, third ... row and column alone."""
    return len(contact) * contact.every**2


def _of_disc(around: Points, middle: Array, radius: float, share: float) -> tuple[Estimate, float] | None:
    """Return the height by the disc of a radius, m, which is such a share of the contact's, and how far a tip may stand above it, m.

    None where it shows no top.
    """
    for most in (ROUGHLY, around.places.size):
        x, y = around.cloud[0] - middle[0], around.cloud[1] - middle[1]
        near = np.flatnonzero(x * x + y * y <= radius * radius)
        if near.size < LEAST_POINTS:
            return None
        top = Top(around.at(near[:: -(-near.size // most)]), middle, even=False)
        if not top.is_convex:
            return None
        middle = top.vertex(0.5 * radius)
    seen = top.estimate(0.5 * radius)
    below, off = float(np.interp(share, RADII, BELOW)), float(np.interp(share, RADII, OFF))
    height = seen.value / (1.0 - below)
    sag = 0.5 * top.curvature * radius**2
    tip = float(np.interp(share, RADII, TIP)) * sag * float(np.interp(sag / radius, STEEP, (0.0, 1.0)))
    return Estimate(height, math.hypot(seen.sd, off * height)), tip
