"""A frame around the contact as cells of a few pixels: few enough to fit, fine enough to see a rim."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.perception.surface import camera_side, check_points
from stretch_bt.perception.types import CONTACT, INVALID, UNDEFORMED, FloatArray, LabelArray, MaskArray

__all__ = ["Cells", "cells_of"]

Array = npt.NDArray[np.float64]

SIDE = 3  # pixels
MARGIN = 25e-3  # m kept around the pixels in contact
COVER = 0.5  # share of a cell's pixels that must be valid


@dataclass(frozen=True, slots=True)
class Cells:
    """Means of `SIDE` x `SIDE` pixels: x, y and height towards the camera (rows, columns), m.

    The height counts from the undeformed membrane. Where `valid` is False the values are 0. `touching` is the share of
    a cell's pixels that are labelled as in contact. `pitch` is the side of a cell, m; `origin` is where the first cell
    begins in the frame, and `shape` the whole frame, (v, u) pixels.
    """

    x: Array
    y: Array
    height: Array
    valid: MaskArray
    touching: Array
    pitch: float
    origin: tuple[int, int]
    shape: tuple[int, int]


def cells_of(points: FloatArray, labels: LabelArray) -> Cells:
    """Return the cells around the contact.

    Parameters
    ----------
    points : (h, w, 3) float, m
        In the camera frame or the membrane frame, told apart as `segment` does.
    labels : (h, w) uint8
        0 undeformed, 1 deformed, 2 in contact, 255 invalid.

    Raises
    ------
    NoContact
        Nothing is valid, or nothing is in contact.
    InvalidInput
        A shape or a type is wrong, or the points are not in metres.
    """
    valid = _checked(points, labels)
    towards = camera_side(points, valid)
    level = _level(points, labels, valid) if towards < 0 else 0.0
    rows, columns = _window(points, labels, valid)
    part, mask = points[rows, columns], valid[rows, columns]
    count = _blocks(mask.astype(np.float32))
    kept = count >= COVER
    share = np.where(kept, count, 1.0)
    planes = [
        np.where(kept, _blocks(np.where(mask, part[..., axis], 0).astype(np.float32)) / share, 0.0) for axis in range(3)
    ]
    height = np.where(kept, towards * (planes[2] - level), 0.0)
    touching = _blocks((labels[rows, columns] == CONTACT).astype(np.float32))
    pitch = _pitch(planes[0], kept)
    return Cells(planes[0], planes[1], height, kept, touching, pitch, (rows.start, columns.start), labels.shape)


def _checked(points: FloatArray, labels: LabelArray) -> MaskArray:
    if not isinstance(labels, np.ndarray) or labels.dtype != np.uint8:
        raise InvalidInput(f"labels are a (h, w) uint8 image of 0, 1, 2 and 255, got {getattr(labels, 'dtype', type(labels))}")
    check_points(points, labels != INVALID)
    valid: MaskArray = (labels != INVALID) & np.isfinite(points).all(axis=2)
    if not valid.any():
        raise NoContact("the frame has no valid pixel")
    if not (labels[valid] == CONTACT).any():
        raise NoContact("no pixel is labelled as in contact")
    width = float(np.ptp(points[valid][:: max(1, valid.size // 4096), :2], axis=0).max())
    if width > 20.0:
        raise InvalidInput(f"points are in metres; a view {width:.3g} m wide is another unit")
    return valid


def _level(points: FloatArray, labels: LabelArray, valid: MaskArray) -> float:
    """Return the distance of the undeformed membrane in the camera frame, m."""
    flat = points[..., 2][valid & (labels == UNDEFORMED)]
    if flat.size >= 50:
        return float(np.median(flat))
    return float(np.quantile(points[..., 2][valid], 0.95))


def _window(points: FloatArray, labels: LabelArray, valid: MaskArray) -> tuple[slice, slice]:
    """Return the rows and columns of the contact and a margin around it, whole cells of them."""
    touching = valid & (labels == CONTACT)
    near = float(np.median(np.abs(np.diff(points[..., 0], axis=1))[valid[:, 1:] & valid[:, :-1]])) if valid.sum() > 1 else 0
    if not near > 0.0:
        raise NoContact("too few pixels are valid to see a shape")
    margin = int(MARGIN / near)
    found = []
    for axis in (1, 0):
        at = np.nonzero(touching.any(axis=axis))[0]
        first, last = max(int(at[0]) - margin, 0), min(int(at[-1]) + 1 + margin, touching.shape[1 - axis])
        found.append(slice(first, first + (last - first) // SIDE * SIDE))
    if min(part.stop - part.start for part in found) < 4 * SIDE:
        raise NoContact("the frame is too small to see a shape")
    return found[0], found[1]


def _blocks(image: npt.NDArray[np.float32]) -> Array:
    """Return the means of whole blocks of `SIDE` x `SIDE` pixels."""
    import cv2

    size = image.shape[1] // SIDE, image.shape[0] // SIDE
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.float64)


def _pitch(x: Array, kept: MaskArray) -> float:
    """Return the median distance between neighbouring cells, m."""
    steps: Any = np.abs(np.diff(x, axis=1))[kept[:, 1:] & kept[:, :-1]]
    if not steps.size:
        raise NoContact("too few pixels are valid to see a shape")
    return float(np.median(steps))
