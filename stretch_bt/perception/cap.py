"""How far a lump that turns is from a ball: the deviation from their mean of the caps that the membrane shows of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_each, check_kind
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.perception.outlines.level import highest_of
from stretch_bt.perception.outlines.level_place import blurred
from stretch_bt.perception.types import MADE, Contact
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate, Length

__all__ = ["Cap", "cap_of", "cap_residual"]

Array = npt.NDArray[np.float64]

REACH = 0.58  # of the ball's radius: a cap 35 degrees wide, which the membrane still follows
CELLS = 7  # to each side of the middle cell, across the reach and a little more
CELL = 1 / 6.2  # of the radius
DOWN = 0.2  # share of the radius: a cap's middle is the mean of all places less than this below its top
LEAST_PIXELS, LEAST_CELLS = 8, 16
PARAMETERS = 3  # of the plane that is taken off each cap


@dataclass(frozen=True, eq=False, repr=False)
class Cap(BriefRepr):
    """Mean heights (15, 15), m, in square cells around the top of a lump, without offset and slope, NaN where not seen.

    `noise`, m, is the standard deviation that the frame's noise gives to one of them.
    """

    heights: Array
    noise: Length


def cap_of(contact: Contact, radius: float) -> Cap:
    """Return the cap that a contact shows of a lump of the volume of a ball of a radius, m.

    Raises
    ------
    NoContact
        Nothing stands in the membrane.
    IllConditioned
        Too little of the cap is seen.
    InvalidInput
        The radius is not above 0.
    """
    check_kind("contact", contact, Contact, MADE)
    if not (is_number(radius) and radius > 0):
        raise InvalidInput(f"a ball has a finite radius above 0 m, not {shown(radius)[:80]}")
    surface = np.asarray(contact.surface, dtype=np.float64)
    heights, valid = blurred(surface)
    over = valid & (heights > highest_of(surface) - DOWN * radius)
    middle = surface[over][:, :2].mean(axis=0)
    away = (surface[..., :2] - middle) / radius
    near = valid & (np.hypot(away[..., 0], away[..., 1]) < REACH)
    if near.sum() < LEAST_PIXELS * LEAST_CELLS:
        raise IllConditioned(
            f"only {int(near.sum())} pixels of the top of the lump are seen, too few to compare; press deeper, or keep reflections off the membrane"
        )
    return _binned(away[near], surface[near][:, 2], contact)


def _binned(places: Array, heights: Array, contact: Contact) -> Cap:
    """Return means in cells of heights (n,), m, at places (n, 2) in radii, less their offset and slope."""
    x, y = places.T
    design = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    fit, *_ = np.linalg.lstsq(design, heights, rcond=None)
    level = heights - design[:, :PARAMETERS] @ fit[:PARAMETERS]
    side = 2 * CELLS + 1
    column, row = (np.rint(v / CELL).astype(np.intp) + CELLS for v in (x, y))
    inside = (column >= 0) & (column < side) & (row >= 0) & (row < side)
    which = row[inside] * side + column[inside]
    counts = np.bincount(which, minlength=side**2)
    sums = np.bincount(which, level[inside], minlength=side**2)
    full = counts >= LEAST_PIXELS
    if full.sum() < LEAST_CELLS:
        raise IllConditioned(
            f"the top of the lump is seen in {int(full.sum())} cells; it takes {LEAST_CELLS}; press deeper, or keep reflections off the membrane"
        )
    cells = np.where(full, sums / np.maximum(counts, 1), np.nan).reshape(side, side)
    alike = min(max(contact.noise_area, 1.0) / float(counts[full].mean()), 1.0)
    return Cap(cells, float(contact.noise) * math.sqrt(alike))


def cap_residual(caps: Sequence[Cap]) -> Estimate:
    """Return the root mean square deviation of caps from their mean, m, with the noise's variance subtracted.

    A ball looks the same from all sides, also through a membrane that shows it changed: that drops out with the mean. Where the
    noise is the larger the residual is 0, and its standard deviation says how much the noise may hide.

    Raises
    ------
    IllConditioned
        There are fewer than two caps, or they have fewer than 16 cells in common.
    """
    check_each("caps", caps, Cap, "`cap_of` makes one of a contact")
    if len(caps) < 2:
        raise IllConditioned(f"to differ it takes two caps, not {len(caps)}; press at one more place")
    cells = np.array([cap.heights for cap in caps])
    shared = cells[:, np.isfinite(cells).all(axis=0)]
    count, places = shared.shape
    if places < LEAST_CELLS:
        raise IllConditioned(f"the caps have {places} cells in common; it takes {LEAST_CELLS}; press deeper")
    variance = float(((shared - shared.mean(axis=0)) ** 2).sum() / ((count - 1) * places))
    hidden = float(np.mean([cap.noise**2 for cap in caps]))
    left = max(variance - hidden, 0.0)
    # about one in four cells is independent, and the variance of noise is known to a tenth
    free = (count - 1) * max(places / 4, 1.0)
    sd = math.hypot(variance * math.sqrt(2 / free), 0.1 * hidden)
    return Estimate(math.sqrt(left), sd / (2 * math.sqrt(max(left, sd))) if sd else 0.0)
