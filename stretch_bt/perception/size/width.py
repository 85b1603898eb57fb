"""How wide a contact is, without a model of its rim."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.perception.pitch import pitch_of
from stretch_bt.perception.size.result import Diameters
from stretch_bt.perception.surface import check_labels, check_points
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray, MaskArray

__all__ = ["contact_width"]

BAND = 1.5e-3  # m to either side of the middle, within which lines are measured
MEDIAN = 1.2533  # standard deviation of a median over a mean's


def contact_width(points: FloatArray, labels: LabelArray) -> Diameters:
    """Return how far the pixels in contact reach along i and along j through their middle.

    Each is the median over the lines of pixels within 1.5 mm of the middle, from the first to the last that is in contact.
    Nothing is corrected: the fillet of an edge, and the errors of a segmentation, are part of it.

    Parameters
    ----------
    points : (h, w, 3) float, m
    labels : (h, w) uint8
        As `segment` returns them.

    Raises
    ------
    NoContact
        No pixel is in contact.
    IllConditioned
        No two neighbours have depth, so that the width of a pixel, and with it the error, is not seen.
    """
    check_points(points)
    check_labels(labels, points)
    touching = (labels == CONTACT) & np.isfinite(points[..., 2])
    if not touching.any():
        raise NoContact("no pixel is in contact: there is nothing to measure; press deeper")
    x, y = (np.where(touching, points[..., axis], np.nan) for axis in (0, 1))
    pixel = [pitch_of(points, np.isfinite(points[..., 2]), axis) for axis in (0, 1)]
    i, i_sd = _reach(x, y, touching, pixel[0])
    j, j_sd = _reach(y.T, x.T, touching.T, pixel[1])
    return Diameters(i, i_sd, j, j_sd)


def _reach(
    along: npt.NDArray[np.float64], across: npt.NDArray[np.float64], touching: MaskArray, pixel: float
) -> tuple[float, float]:
    """Return how far the rows near the middle reach, m, and its standard deviation, of which half a pixel at either end is part."""
    rows = np.flatnonzero(touching.any(axis=1))
    place = np.nanmean(across[rows], axis=1)
    near = rows[np.abs(place - np.nanmedian(across)) <= max(BAND, float(np.abs(place - np.nanmedian(across)).min()))]
    spans = np.nanmax(along[near], axis=1) - np.nanmin(along[near], axis=1)
    pitch = float(np.median(spans / np.maximum(np.count_nonzero(touching[near], axis=1) - 1, 1)))
    pitch = pitch or pixel  # where no line holds two pixels
    if pitch == 0.0:
        raise IllConditioned(
            "the contact is single pixels without neighbours, so that no width with its error can be given; keep reflections off the membrane"
        )
    spread = float(np.std(spans, ddof=1)) / math.sqrt(len(spans)) if len(spans) > 1 else 0.0
    return float(np.median(spans)) + pitch, math.hypot(MEDIAN * spread, pitch / math.sqrt(6.0))
