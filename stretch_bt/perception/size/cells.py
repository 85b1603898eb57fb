"""A frame around the contact as cells of a few pixels: few enough to fit, fine enough to see a rim."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.perception.clean import without_flying
from stretch_bt.perception.pitch import check_pitch, pitch_of
from stretch_bt.perception.surface import camera_side, check_labels, check_points
from stretch_bt.perception.types import CONTACT, INVALID, UNDEFORMED, FloatArray, LabelArray, MaskArray

__all__ = ["HeightCells", "cells_of"]

Array = npt.NDArray[np.float64]

SIDE = 3  # pixels
MARGIN = 25e-3  # m kept around the pixels in contact
COVER = 0.5  # share of a cell's pixels that must be valid
SAMPLE = 5000  # pixels that are enough to distinguish frames and units
WIDEST = 20.0  # m


@dataclass(frozen=True, slots=True)
class HeightCells:
    """Means of `SIDE` x `SIDE` pixels: x, y and height towards the camera (rows, columns), m.

    The height counts from the undeformed membrane. Where `valid` is False the values are 0. `touching` is the share of
    a cell's pixels that are labelled as in contact. `pitches` are the width and the height of a cell, m; `origin` is where the first cell
    begins in the frame, and `shape` the whole frame, (v, u) pixels.
    """

    x: Array
    y: Array
    height: Array
    valid: MaskArray
    touching: Array
    pitches: tuple[float, float]
    origin: tuple[int, int]
    shape: tuple[int, int]

    @property
    def area(self) -> float:
        """Area of a cell, m^2."""
        return self.pitches[0] * self.pitches[1]


def cells_of(points: FloatArray, labels: LabelArray) -> HeightCells:
    """Return the cells around the contact.

    Parameters
    ----------
    points : (h, w, 3) float, m
        In the camera frame or the membrane frame, distinguished as `segment` does.
    labels : (h, w) uint8
        0 undeformed, 1 deformed, 2 in contact, 255 invalid.

    Raises
    ------
    NoContact
        Nothing is valid, or nothing is in contact.
    InvalidInput
        A shape or a type is wrong, or the points are not in metres.
    """
    towards, level = _side(points, labels)
    rows, columns = _window(points, labels)
    part, classes = points[rows, columns], labels[rows, columns]
    mask = (classes != INVALID) & np.isfinite(part[..., 0] + part[..., 1] + part[..., 2])
    mask = without_flying(part, mask, pitch_of(part, mask))
    if not mask.any():
        raise NoContact("no pixel around the contact is valid: its rim is not seen; keep reflections off the membrane")
    origin = part[np.unravel_index(int(np.argmax(mask)), mask.shape)]  # single precision is enough near it
    count = _blocks(mask.astype(np.float32))
    kept = count >= COVER
    share = np.where(kept, count, 1.0)
    planes = [
        np.where(kept, _blocks(np.where(mask, part[..., n] - origin[n], 0).astype(np.float32)) / share + origin[n], 0.0)
        for n in range(3)
    ]
    height = np.where(kept, towards * (planes[2] - level), 0.0)
    touching = _blocks((mask & (classes == CONTACT)).astype(np.float32))
    pitches = _pitch_along(planes[0], kept), _pitch_along(planes[1].T, kept.T)
    return HeightCells(planes[0], planes[1], height, kept, touching, pitches, (rows.start, columns.start), labels.shape)


def _side(points: FloatArray, labels: LabelArray) -> tuple[int, float]:
    """Return +1 where z points to the camera, -1 where away, and z of the undeformed membrane, m, from a sample."""
    check_points(points)
    check_labels(labels, points)
    step = max(1, round((labels.size / SAMPLE) ** 0.5))
    some, classes = points[::step, ::step], labels[::step, ::step]
    valid: MaskArray = (classes != INVALID) & np.isfinite(some).all(axis=2)
    if not valid.any():
        raise NoContact(
            "the frame has no valid pixel, or hardly any: nothing is seen; look at the camera, and at `plane_distance` of the cell"
        )
    wide = float(np.ptp(some[valid][:, :2], axis=0).max())
    if wide > WIDEST:
        raise InvalidInput(f"points are in metres; a view {wide:.3g} m wide is in another unit")
    towards = camera_side(some, valid)
    if towards > 0:
        return towards, 0.0
    flat = some[..., 2][valid & (classes == UNDEFORMED)]
    return towards, float(np.median(flat) if flat.size >= 20 else np.quantile(some[..., 2][valid], 0.95))


def _window(points: FloatArray, labels: LabelArray) -> tuple[slice, slice]:
    """Return the rows and columns of the contact and a margin around it, whole cells of them."""
    touching = labels == CONTACT
    lines = [np.nonzero(touching.any(axis=axis))[0] for axis in (1, 0)]
    if not lines[0].size:
        raise NoContact("no pixel is labelled as in contact: there is nothing to measure; press deeper")
    middle = [int(np.median(at)) for at in lines]
    along = points[:, middle[1], 1], points[middle[0], :, 0]
    found = []
    for at, length, places in zip(lines, labels.shape, along, strict=True):
        steps = np.abs(np.diff(np.where(np.isfinite(places), places, np.nan)))
        margin = int(MARGIN / float(np.median(steps[steps > 0.0]))) if (steps > 0.0).any() else 0
        first, last = max(int(at[0]) - margin, 0), min(int(at[-1]) + 1 + margin, length)
        found.append(slice(first, first + (last - first) // SIDE * SIDE))
    if min(part.stop - part.start for part in found) < 4 * SIDE:
        raise NoContact(
            "too few pixels are valid to see a shape; keep reflections off the membrane, or average more frames"
        )
    return found[0], found[1]


def _blocks(image: npt.NDArray[np.float32]) -> Array:
    """Return the means of whole blocks of `SIDE` x `SIDE` pixels."""
    import cv2

    size = image.shape[1] // SIDE, image.shape[0] // SIDE
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.float64)


def _pitch_along(x: Array, kept: MaskArray) -> float:
    """Return the median distance between neighbouring cells of a row, m."""
    steps: Any = np.abs(np.diff(x, axis=1))[kept[:, 1:] & kept[:, :-1]]
    if not steps.size:
        raise NoContact(
            "too few pixels are valid to see a shape; keep reflections off the membrane, or average more frames"
        )
    pitch = float(np.median(steps))
    check_pitch(pitch / SIDE)
    return pitch
