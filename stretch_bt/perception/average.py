"""Averaging frames of a still scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_each
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.perception.types import FRAME

__all__ = ["average_frames", "check_one_hand", "in_finer_unit"]

ONE_STRETCH = 2e-3  # m, within which the fingers of a hand that stands still are read
ONE_TURN = 0.02  # rad, within which a hand that stands still is read: a millimetre at the rim of a membrane
ONE_HEIGHT = 5e-3  # m, along any axis, within which a hand that has just been stopped stands
FINER = 16  # the mean is kept in sixteenths of a count, so that averaging gains what quantisation lost
FAR = 2.0  # distances of the flat membrane, past which a pixel is none of the hand's: a membrane that sticks is pulled by millimetres
MOST_COUNTS = np.iinfo(np.uint16).max


def check_one_hand(what: str, frame: DepthFrame, first: DepthFrame) -> None:
    """Raise InvalidInput unless two frames are of one camera and of one membrane at one stretch; `what` needs that."""
    if frame.intrinsics != first.intrinsics:
        raise InvalidInput(f"a {what} needs frames of one camera: their intrinsics differ")
    for name in ("stretch", "plane_distance"):
        now, before = getattr(frame, name), getattr(first, name)
        if (now is None) != (before is None) or (now is not None and abs(now - before) > ONE_STRETCH):
            raise InvalidInput(
                f"a {what} needs frames of one membrane: their {name} differs by more than {ONE_STRETCH * 1e3:g} mm"
                f"; begin a new {what.rsplit(maxsplit=1)[-1]} after a change of stretch"
            )


def average_frames(frames: Sequence[DepthFrame]) -> DepthFrame:
    """Return the mean of frames of a still scene, as a frame of a finer unit; times and places are the last frame's.

    A pixel is valid when at least half of the frames are valid there, unless it is far behind the hand and past what the finer unit
    can count: more than twice as far as the flat membrane.

    Raises
    ------
    InvalidInput
        There are no frames, or they differ in unit or intrinsics.
    IllConditioned
        The hand moved, turned or stretched the membrane between the frames, or they place the flat membrane at different distances.
    """
    check_each("frames", frames, DepthFrame, FRAME)
    if not frames:
        raise InvalidInput("an average needs at least one frame")
    last = frames[-1]
    if any(f.unit != last.unit or f.intrinsics != last.intrinsics for f in frames):
        raise InvalidInput("an average needs frames of one camera: their unit or intrinsics differ")
    _check_still("stretch of the membrane", [f.stretch for f in frames], ONE_STRETCH)
    _check_still("height of the hand", [f.hand_height for f in frames], ONE_HEIGHT)
    poses = [f.pose for f in frames]
    for axis, name in enumerate("xy"):
        _check_still(f"{name} of the hand", [None if p is None else p.position[axis] for p in poses], ONE_HEIGHT)
    _check_unturned(poses)
    _check_still("distance of the flat membrane", [f.plane_distance for f in frames], ONE_STRETCH)
    stack = np.stack([f.raw for f in frames])
    seen = np.count_nonzero(stack, axis=0)
    total = stack.sum(axis=0, dtype=np.uint64)
    return in_finer_unit(last, np.where(2 * seen >= len(frames), total / np.maximum(seen, 1), 0.0))


def in_finer_unit(frame: DepthFrame, counts: npt.NDArray[np.floating[Any]]) -> DepthFrame:
    """Return a frame with an image (h, w) of counts that are not whole, in the finest unit that holds the hand, down to a sixteenth.

    Pixels more than twice as far as the flat membrane do not choose the unit, and are invalid where it cannot count them; where the
    frame does not know how far that is, all choose it.
    """
    within = counts
    if frame.plane_distance is not None:
        within = counts[counts <= FAR * frame.plane_distance / frame.unit]
    most = float(within.max(initial=0.0)) or float(counts.max(initial=0.0))
    finer = min(max(int(MOST_COUNTS / max(most, 1.0)), 1), FINER)
    fine = np.rint(finer * counts)
    raw = np.where((fine > 0) & (fine <= MOST_COUNTS), fine, 0).astype(np.uint16)
    return replace(frame, raw=raw, unit=frame.unit / finer)


def _check_still(what: str, values: Sequence[float | None], most: float) -> None:
    known = [value for value in values if value is not None]
    if known and not max(known) - min(known) <= most:
        raise IllConditioned(
            f"the {what} goes from {1e3 * min(known):.1f} to {1e3 * max(known):.1f} mm over the {len(values)} frames, so that their mean"
            " shows neither; wait until the hand stands still, then take the frames"
        )


def _check_unturned(poses: Sequence[Pose | None]) -> None:
    known = [pose for pose in poses if pose is not None]
    first = known[0] if known else None
    turned = [pose.matrix() for pose in known if first is not None and pose.rotation != first.rotation]
    if first is None or not turned:
        return
    cosine = min((float(np.sum(first.matrix() * matrix)) - 1.0) / 2.0 for matrix in turned)
    angle = math.acos(min(max(cosine, -1.0), 1.0))
    if angle > ONE_TURN:
        raise IllConditioned(
            f"the hand turns by {math.degrees(angle):.1f} degrees over the {len(poses)} frames, so that their mean shows neither; wait until"
            " the hand stands still, then take the frames"
        )
