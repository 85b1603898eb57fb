"""Contacts from heights that somebody made by hand, for tests and for sensors of other kinds."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind
from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.frames import Pose, as_length, as_numbers
from stretch_bt.perception.pitch import check_pitch
from stretch_bt.perception.tension import check_stretch
from stretch_bt.perception.types import CONTACT, DEFORMED, INVALID, UNDEFORMED, Contact, FloatArray, LabelArray

__all__ = ["contact_from_heights"]

#: fewest pixels along a side of an image
LEAST = 8
#: largest height above the plane over the extent of the image: heights in mm exceed it by far
STEEPEST = 5.0


def contact_from_heights(
    heights: npt.ArrayLike,
    pixel: float | str,
    *,
    noise: float | str,
    labels: npt.ArrayLike | None = None,
    stretch: float | None = None,
    pose: Pose | None = None,
    time: float = 0.0,
) -> Contact:
    """Do what `Contact.from_heights` says."""
    if pose is not None:
        check_kind("pose", pose, Pose)
    z = _heights(heights)
    pixel, noise = as_length("pixel", pixel), as_length("noise", noise)
    if not (math.isfinite(pixel) and pixel > 0 and math.isfinite(noise) and noise > 0):
        raise InvalidInput(
            f"pixel and noise are lengths above 0 m, got {pixel!r} and {noise!r}; write 0.0005 for 0.5 mm"
        )
    check_pitch(pixel)
    _check_unit(z, pixel)
    surface = _surface(z, pixel)
    known = np.isfinite(z)
    check_stretch(stretch)
    shown, sure = _labelled(surface, known, stretch) if labels is None else _given(labels, known)
    surface[shown == INVALID] = np.nan
    touching = surface[shown == CONTACT]
    if not len(touching):
        raise NoContact(
            "no part of these heights is curved and raised as a contact is; raise a rounder or flatter top out of the plane, or say with"
            " 'labels' which pixels touch"
        )
    place = Pose() if pose is None else pose
    down = np.tile(np.array([0.0, 0.0, -1.0]), (len(touching), 1))
    return Contact(touching, down, shown, noise, place.height, stretch, time, surface, sure, place)


def _heights(heights: npt.ArrayLike) -> FloatArray:
    z = as_numbers("heights are", heights)
    if z.ndim != 2 or z.dtype.kind not in "iuf" or min(z.shape) < LEAST:
        raise InvalidInput(
            f"heights are an array (h, w) of numbers, m, at least {LEAST} by {LEAST}, got {z.dtype} {z.shape}"
        )
    made = z.astype(np.float64)
    made[~np.isfinite(made)] = np.nan
    if np.isnan(made).all():
        raise NoContact(
            "no pixel of these heights is finite, so that nothing is seen; give heights where the membrane was seen"
        )
    return made


def _check_unit(z: FloatArray, pixel: float) -> None:
    highest, across = float(np.nanmax(np.abs(z))), pixel * max(z.shape)
    if highest > STEEPEST * across:
        raise InvalidInput(
            f"heights up to {highest:.3g} m over an image of {across:.3g} m; give heights and pixel in m, heights from the membrane's plane"
        )


def _surface(z: FloatArray, pixel: float) -> FloatArray:
    """Return the points (h, w, 3), m, membrane frame, with the middle of the image at x = y = 0; NaN where nothing is known."""
    rows, columns = ((np.arange(n) - (n - 1) / 2) * pixel for n in z.shape)
    y, x = np.meshgrid(rows, columns, indexing="ij")
    surface: FloatArray = np.stack([x, y, z], axis=2)
    surface[np.isnan(z)] = np.nan
    return surface


def _labelled(
    surface: FloatArray, known: npt.NDArray[np.bool_], stretch: float | None
) -> tuple[LabelArray, npt.NDArray[np.float32]]:
    from stretch_bt.perception.segmentation import classify

    found = classify(surface, known, stretch=stretch, towards=1)
    return found.labels, found.confidence


def _given(labels: npt.ArrayLike, known: npt.NDArray[np.bool_]) -> tuple[LabelArray, npt.NDArray[np.float32]]:
    """Return given labels, or a mask of the pixels in contact, as labels, and their certainty: 1 where a pixel is valid."""
    given = as_numbers("labels are", labels, "labels.filled(255), or filled(False) where they are bool")
    if given.shape != known.shape:
        raise InvalidInput(f"labels of heights {known.shape} have that shape, got {given.shape}")
    if given.dtype.kind == "b":
        given = np.where(given, CONTACT, DEFORMED)
    if not np.isin(given, (UNDEFORMED, DEFORMED, CONTACT, INVALID)).all():
        raise InvalidInput(
            "labels are 0 undeformed, 1 deformed, 2 in contact, 255 invalid, or True where the membrane touches"
        )
    shown = np.where(known, given, INVALID).astype(np.uint8)
    return shown, (shown != INVALID).astype(np.float32)
