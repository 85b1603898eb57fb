"""The outline of a flat object: the border of its contact in the plane, its area, its length and how round it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_counts, check_unmasked
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import IllConditioned, InvalidInput, NoAnswer, shown
from stretch_bt.frames import as_numbers
from stretch_bt.perception.outlines.polyline import (
    Array,
    area_of,
    even,
    noise_of,
    perimeter_of,
    redrawn,
    smoothed,
    spacing_of,
)
from stretch_bt.perception.outlines.roundness import CORNERS, REPLICATES, Method, Roundness, contour_of, roundness
from stretch_bt.perception.outlines.trace import BLUR, trace
from stretch_bt.perception.types import CONTACT, INVALID, FloatArray, MaskArray
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Area, Length

__all__ = ["Outline", "outline_of", "placed"]

HOLE = 9  # pixels across, from which pixels without depth are an area and no dropouts
UNLABELLED = 7.5e-3  # m from such an area, within which curvature cannot be measured and nothing is labelled as contact
BESIDE_HOLE = 0.2  # share of an outline there
# Relative error of a circularity over the relative part of a perimeter that is not seen: 2 where a wiggle takes no area, 1 where a corner that is
# rounded takes as much of it (`python benchmarks/outline_errors.py`)
SHAPE = 1.5
STAIRS = 1.1e-3  # relative error of a perimeter from the stairs of its pixels, which a blur does not quite take away: of discs drawn anywhere
LEAST_PIXEL_NOISE = 0.07  # pixels: error of an edge's place from drawing it on a grid and blurring it


@dataclass(frozen=True, slots=True, repr=False)
class Outline(BriefRepr):
    """A closed line around a region, with what it encloses.

    `vertices` (n, 2), m, x and y of the membrane frame, in order; the last joins the first. The standard deviations include the
    border's own roughness and `place_sd`, m, the standard deviation of an error that moves all of the line out or in, the area
    by perimeter x error and the perimeter by 2 pi x error. A region of pixels has none. The blur of a border of pixels
    takes about a pixel of perimeter off each corner of a square; the standard deviations include about what it takes. `hidden` is the
    standard deviation of a circularity from the parts of the body's shape that the line does not show.
    """

    vertices: FloatArray
    area: Area
    area_sd: Area
    perimeter: Length
    perimeter_sd: Length
    hidden: float = 0.0
    place_sd: Length = 0.0

    def roundness(self, method: Method = "contour") -> Roundness:
        """Return the circularity with its standard deviation and the method."""
        found = roundness(self.vertices, method=method)
        return replace(found, circularity_sd=math.hypot(found.circularity_sd, self.hidden))


def outline_of(region: npt.NDArray[Any], where: FloatArray | float, *, label: int = CONTACT) -> Outline:
    """Return the outer outline of a region of pixels, in the plane of the flat membrane.

    Parameters
    ----------
    region : (h, w) uint8 or bool
        Labels as `segment` gives them, of which those equal to `label` are taken, or a mask.
    where : (h, w, 3) float, m, or a float, m
        The point of each pixel in the membrane frame, or the distance from pixel to pixel.

    Raises
    ------
    NoContact
        The region has no pixel.
    IllConditioned
        It is cut by the edge of the image or by pixels without depth, too small, or in several pieces.
    InvalidInput
        An array has another shape or type.
    """
    check_counts(0, label=label)
    inside, valid = _region(region, label)
    if not isinstance(where, np.ndarray):
        if not (is_number(where) and where > 0):
            raise InvalidInput(
                f"the distance from pixel to pixel is a positive number of metres, got {shown(where)[:80]}; or give the points of the"
                " pixels, an array of numpy"
            )
        pitch = float(where)
        line = trace(inside, valid)
        _check_seen(line, inside, valid, pitch)
        return _outline(line * pitch, pitch, _lost_at_corners(line, inside, valid))
    points = where
    check_unmasked("the points of a region are", points)
    if points.shape != (*inside.shape, 3) or points.dtype.kind != "f":
        raise InvalidInput(
            f"the points of a region of shape {inside.shape} have shape {(*inside.shape, 3)} and are floats, "
            f"got {points.dtype} {points.shape}"
        )
    valid &= np.isfinite(points).all(axis=2)
    line = trace(inside, valid)
    vertices = _in_plane(line, points, inside & valid)
    pitch = perimeter_of(_curve(vertices)) / perimeter_of(_curve(line))
    _check_seen(line, inside, valid, pitch)
    return _outline(vertices, pitch, _lost_at_corners(line, inside & valid, valid))


def placed(outline: Outline, sd: float, uneven: float = 0.0) -> Outline:
    """Return an outline with `sd`, m, the standard deviation of an error of place of all of it, added to its own.

    `uneven`, m, is a further standard deviation of its perimeter.
    """
    ratio, perimeter = outline.roundness().circularity, outline.perimeter
    lost = ratio * math.hypot((perimeter / outline.area - 4.0 * math.pi / perimeter) * sd, SHAPE * uneven / perimeter)
    return replace(
        outline,
        area_sd=math.hypot(outline.area_sd, perimeter * sd),
        perimeter_sd=math.hypot(outline.perimeter_sd, 2.0 * math.pi * sd, uneven),
        hidden=math.hypot(outline.hidden, lost),
        place_sd=math.hypot(outline.place_sd, sd),
    )


def _check_seen(line: Array, inside: MaskArray, valid: MaskArray, pitch: float) -> None:
    """Refuse an outline (n, 2), pixels, that runs for long beside an area without depth: a contact is not labelled there."""
    import cv2

    hole = cv2.morphologyEx((~valid).astype(np.uint8), cv2.MORPH_OPEN, np.ones((HOLE, HOLE), np.uint8))
    away = cv2.distanceTransform((1 - hole).astype(np.uint8), cv2.DIST_L2, 3)
    u, v = np.clip(np.rint(line).astype(np.intp).T, 0, np.array(inside.shape)[::-1, None] - 1)
    if np.mean(away[v, u] * pitch < UNLABELLED) > BESIDE_HOLE:
        raise IllConditioned(
            "an area without depth is beside the region and may hide a part of it; keep reflections off the membrane, or average more frames"
        )


def _region(region: npt.NDArray[Any], label: int) -> tuple[MaskArray, MaskArray]:
    """Return which pixels are in a region, and which are valid."""
    image = as_numbers("a region is", region, "region.filled(255), or filled(False) where it is bool")
    if image.ndim != 2 or image.dtype not in (np.dtype(bool), np.dtype(np.uint8)):
        raise InvalidInput(f"a region is an (h, w) image of uint8 labels or of bool, got {image.dtype} {image.shape}")
    if image.dtype == bool:
        return image, np.ones(image.shape, dtype=bool)
    return np.asarray(image == label), np.asarray(image != INVALID)


def _curve(vertices: Array) -> npt.NDArray[np.complex128]:
    return np.asarray(vertices[:, 0] + 1j * vertices[:, 1])


def _in_plane(line: Array, points: FloatArray, inside: MaskArray) -> Array:
    """Return x and y, m, of places given in pixels, by a quadratic map fitted to the region's own points."""
    v, u = np.nonzero(inside)
    middle, size = np.array([u.mean(), v.mean()]), max(u.std(), v.std(), 1.0)
    design = _quadratic((np.column_stack([u, v]) - middle) / size)
    known = points[inside][:, :2].astype(np.float64)
    fit, _, rank, _ = np.linalg.lstsq(design, known, rcond=None)
    if rank < design.shape[1]:
        raise IllConditioned(
            "too few pixels of the region have depth to place its outline; keep reflections off the membrane, or move the camera nearer"
        )
    return np.asarray(_quadratic((line - middle) / size) @ fit)


def _quadratic(at: Array) -> Array:
    x, y = at.T
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def _lost_at_corners(line: Array, inside: MaskArray, valid: MaskArray) -> float:
    """Return about how many pixels of perimeter the blur takes off the corners of an outline (n, 2), pixels.

    Off a sharp corner it takes in proportion to its width, so that twice the width takes as much again. Off a smooth outline
    it takes in proportion to the square, which is a small part and known.
    """
    wider = 2.0 * BLUR
    try:
        blunt = perimeter_of(smoothed(even(contour_of(trace(inside, valid, wider)))))
    except NoAnswer:  # the wider blur leaves no region
        return 0.0
    sharp = perimeter_of(smoothed(even(contour_of(line))))
    return max(sharp - blunt - 2.0 * math.pi**2 * (wider**2 - BLUR**2) / sharp, 0.0)


def _outline(vertices: Array, pitch: float, lost: float) -> Outline:
    """Return the outline with the errors that its roughness gives it; `pitch` is the size of a pixel, m, `lost` the pixels lost at corners."""
    curve = contour_of(vertices)
    area = area_of(curve)
    if len(curve) < CORNERS:
        raise IllConditioned(
            f"an outline of {len(curve)} vertices is too coarse to separate its noise from its shape; move the camera nearer"
        )
    curve = even(curve)
    least = LEAST_PIXEL_NOISE * pitch
    noise = max(noise_of(curve)[0], least)
    perimeter = perimeter_of(smoothed(curve))
    others = [perimeter_of(smoothed(other)) for other in redrawn(curve, REPLICATES, least)]
    # The noise of a blurred border is the same over the blur's width: the integral of its autocorrelation.
    alike = max(2.0 * np.sqrt(np.pi) * BLUR * pitch, spacing_of(curve))
    # Corners and stairs change the perimeter far more than the area.
    relative = math.hypot(STAIRS, lost * pitch / perimeter)
    return Outline(
        vertices,
        area,
        noise * float(np.sqrt(perimeter * alike)),
        perimeter,
        math.hypot(float(np.std(others, ddof=1)), relative * perimeter),
        hidden=8.0 * math.pi * area / perimeter**2 * relative,
    )
