"""The outline of what stands highest in the membrane, at a level below its top."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import InvalidInput, NoContact, shown
from stretch_bt.perception.outlines.level_place import TOP, blurred, with_level_errors
from stretch_bt.perception.outlines.outline import Outline, outline_of
from stretch_bt.perception.types import FloatArray, SurfaceNoise
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Length

__all__ = ["highest_of", "outline_at"]

# Of a circularity, by what it lacks of 1: the membrane's shoulder takes some three tenths off corners and cracks, and its tensions make a disc
# look no rounder than 0.99; cookies of 0.87 to 0.99 under a membrane that bends (`python benchmarks/cookie.py --seeds 0-6`, both trees).
HIDDEN, SHOULDER = 0.008, 0.3
LEAST = 1e-3  # m over the flat membrane, below which nothing stands in it


def highest_of(surface: FloatArray) -> Length:
    """Return the height of the highest place of a surface (h, w, 3), m, membrane frame, NaN where invalid.

    It is the height that half a per cent of the pixels exceed, after a blur. It needs no curvature, so that it serves for flat tops
    too; a round one comes out low by some tenths of a millimetre.

    Raises
    ------
    NoContact
        No pixel is valid, or nothing stands 1 mm over the flat membrane.
    """
    heights, valid = blurred(surface)
    if not valid.any():
        raise NoContact("the frame has no valid pixel: nothing is seen; look at the camera")
    top = float(np.percentile(heights[valid], 100 - TOP))
    if top < LEAST:
        raise NoContact(
            f"nothing stands in the membrane: its highest place is {top * 1e3:.1f} mm over its plane; press deeper"
        )
    return top


def outline_at(surface: FloatArray, below: float, *, noise: SurfaceNoise | None = None) -> Outline:
    """Return the outline of the highest place of a membrane at a level below it, in the plane of the flat membrane.

    Over a flat body under a slack membrane it is the border of the body rounded by its shoulder: unlike the border of contact it
    needs no curvature, of which noise leaves little. The error of its circularity includes what the shoulder hides of the body, so that
    cookies closer than some 0.05 are not ranked by it.

    Parameters
    ----------
    surface : (h, w, 3) float, m, membrane frame
        The point of each pixel, NaN where invalid.
    below
        Distance, m, of the level below the top that `highest_of` returns.
    noise
        Noise of the surface, as a contact has it; unless given, none is counted.

    Raises
    ------
    NoContact
        Nothing stands that high in the membrane.
    IllConditioned
        The outline is in pieces, or cut by the edge of the image or by pixels without depth.
    InvalidInput
        The surface has another shape, or the level is not above 0.
    """
    import cv2

    if not (is_number(below) and below > 0):
        raise InvalidInput(f"a level is finite and above 0 m below the top, not {shown(below)}")
    if noise is not None:
        check_kind("noise", noise, SurfaceNoise, "`surface_noise` measures it")
    top = highest_of(surface)
    heights, valid = blurred(surface)
    if below > top - LEAST:
        raise NoContact(
            f"the membrane is raised by {top * 1e3:.1f} mm, too little for an outline {below * 1e3:g} mm below"
            " its top; press deeper, or ask for an outline nearer to the top"
        )
    over = ((heights > top - below) & valid).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(over)
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])) if count > 1 else 0
    region = np.asarray(labels == largest)
    outline = outline_of(
        np.asarray(over > 0), surface
    )  # with the other parts, which it refuses where they are no specks
    shape = HIDDEN + SHOULDER * max(1.0 - outline.roundness().circularity, 0.0)
    outline = replace(outline, hidden=math.hypot(outline.hidden, shape))
    return with_level_errors(outline, surface, region, noise)
