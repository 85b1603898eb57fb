"""What was read of an object's top since it was approached."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from stretch_bt.behaviors._membrane import height_of_top, left_of_pattern, told_by_membrane
from stretch_bt.model import Series
from stretch_bt.model.palpation.balance import presses_of
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.tree.context import Context
from stretch_bt.units import Estimate, Length

__all__ = [
    "Fitted",
    "Reading",
    "Touch",
    "fitted",
    "fixed_part",
    "forget_object",
    "frames_at",
    "noise_at",
    "of_one_kind",
    "of_press",
    "reading_sd",
    "readings_of",
    "tell_again",
]

LEAST_TOUCHES = 2  # that tell where the top stands without a force
FIXED, FRAME_NOISE = (
    3e-5,
    3e-4,
)  # m; what no averaging takes away of a height that is off by so much in one frame, or by more


@dataclass(frozen=True, slots=True)
class Touch:
    """A first touch: points (h, w, 3), m, membrane frame, valid and labels (h, w); frames averaged.

    `curvature`, 1/m, is what its height was told with, `by_membrane` whether the whole membrane was asked; `alone` is true where the
    contact alone told it all the same.
    """

    points: FloatArray
    valid: MaskArray
    labels: LabelArray
    frames: int
    curvature: float | None = None
    by_membrane: bool = False
    alone: bool = False


@dataclass(frozen=True, slots=True)
class Reading:
    """The height of the top, m, world, with its standard deviation, in so many frames averaged, at a stretch and a depth, m."""

    stretch: Length
    depth: Length
    height: Length
    sd: Length
    touch: Touch | None = None  # what `approach` saw, where it took it
    frames: int = 1

    @property
    def hand(self) -> Length:
        """World height of the hand's flat membrane."""
        return self.height - self.depth


@dataclass(frozen=True, slots=True)
class Fitted:
    """The latest curve through the readings."""

    series: Series
    last: Reading


def readings_of(context: Context) -> list[Reading]:
    """Return the readings of the run so far; `approach` empties the list."""
    found: list[Reading] = context.memory.setdefault(Reading, [])
    return found


def forget_object(context: Context) -> None:
    """Forget the readings of an object and the curve through them."""
    readings_of(context).clear()
    context.memory.pop(Fitted, None)


def fitted(context: Context) -> Fitted | None:
    """Return what `track_drop` fitted last, or None before its first fit since `approach`."""
    found: Fitted | None = context.memory.get(Fitted)
    return found


def tell_again(context: Context, curvature: Estimate, *, by_membrane: bool) -> None:
    """Tell the heights of first touches again, now that the curvature of the top, 1/m, is known.

    `by_membrane` says whether the press was told by the whole membrane: heights of two kinds do not go together.
    """
    readings = readings_of(context)
    for i, reading in enumerate(readings):
        touch = reading.touch
        if touch is not None and (touch.curvature, touch.by_membrane) != (curvature.value, by_membrane):
            top, whole = height_of_top(
                context, touch.points, touch.valid, touch.labels, reading.stretch, curvature, by_membrane=by_membrane
            )
            alone = by_membrane and not whole
            told = replace(touch, curvature=curvature.value, by_membrane=by_membrane, alone=alone)
            readings[i] = Reading(reading.stretch, top.value, reading.hand + top.value, top.sd, told, touch.frames)


def of_one_kind(readings: list[Reading]) -> list[Reading]:
    """Return the readings without first touches that the contact alone told where at least two others were told by the whole membrane.

    The two kinds differ by some tenths of a millimetre over a top that flattens, which would be a part of the deflection.
    """
    kept = [reading for reading in readings if reading.touch is None or not reading.touch.alone]
    return kept if sum(reading.touch is not None for reading in kept) >= LEAST_TOUCHES else readings


def of_press(readings: list[Reading], latest: Reading) -> list[Reading]:
    """Return those of one press with the latest reading, which may be the last of them or come after them.

    A hand that went away and came back is at another press: it need not stand off as it did.
    """
    numbers = presses_of([*readings, latest])
    return [reading for reading, number in zip(readings, numbers, strict=False) if number == numbers[-1]]


def frames_at(context: Context, press: Reading) -> int:
    """Return how many frames the readings of a press hold together."""
    return sum(reading.frames for reading in of_press(readings_of(context), press))


def noise_at(context: Context, press: Reading) -> tuple[Length, Length]:
    """Return by how much a height of a press is off in one frame, m, as its readings state it, and what of it more frames leave, m."""
    readings = of_press(readings_of(context), press)
    left = 0.0 if told_by_membrane(context) else left_of_pattern(context) or 0.0
    white = [max(reading.sd**2 - left**2, 0.0) * reading.frames for reading in readings]
    noise = math.sqrt(sum(white) / len(white))
    return noise, math.hypot(left, fixed_part(noise))


def reading_sd(stated: float, frames: int, frame_noise: float) -> float:
    """Return the sd of a height, m, seen in so many frames: as stated, or what a camera of such a noise leaves at least."""
    return max(stated, math.hypot(fixed_part(frame_noise), frame_noise / math.sqrt(frames)))


def fixed_part(frame_noise: Length) -> Length:
    """Return what no averaging takes away of a height that is off by so much in one frame, m."""
    return FIXED * min(frame_noise / FRAME_NOISE, 1.0)
