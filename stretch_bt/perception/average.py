"""Averaging frames of a still scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stretch_bt.arguments import check_each
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.types import FRAME

__all__ = ["average_frames"]

ONE_STRETCH = 2e-3  # m, within which the fingers of a hand that stands still are read
ONE_HEIGHT = 5e-3  # m, along any axis, within which a hand that has just been stopped stands
FINER = 16  # the mean is kept in sixteenths of a count, so that averaging gains what quantisation lost


def average_frames(frames: Sequence[DepthFrame]) -> DepthFrame:
    """Return the mean of frames of a still scene, as a frame of a finer unit; times and places are the last frame's.

    A pixel is valid when at least half of the frames are valid there.

    Raises
    ------
    InvalidInput
        There are no frames, or they differ in unit or intrinsics.
    IllConditioned
        The hand moved, or stretched the membrane, between the frames.
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
    stack = np.stack([f.raw for f in frames])
    seen = np.count_nonzero(stack, axis=0)
    total = stack.sum(axis=0, dtype=np.uint64)
    mean = np.where(2 * seen >= len(frames), FINER * total / np.maximum(seen, 1), 0.0)
    finer = FINER if mean.max(initial=0.0) <= np.iinfo(np.uint16).max else 1
    raw = np.rint(mean * (finer / FINER)).astype(np.uint16)
    return replace(last, raw=raw, unit=last.unit / finer)


def _check_still(what: str, values: Sequence[float | None], most: float) -> None:
    known = [value for value in values if value is not None]
    if known and not max(known) - min(known) <= most:
        raise IllConditioned(
            f"the {what} goes from {1e3 * min(known):.1f} to {1e3 * max(known):.1f} mm over the {len(values)} frames, so that their mean"
            " shows neither; wait until the hand stands still, then take the frames"
        )
