"""What was read of an object's top since it was approached."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stretch_bt.behaviors._membrane import height_of_top
from stretch_bt.model.palpation.balance import presses_of
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate, Length

if TYPE_CHECKING:
    from stretch_bt.behaviors.records import Mounting
    from stretch_bt.hardware.hand import HandGeometry

__all__ = [
    "FirstTouch",
    "Reading",
    "creep_of",
    "fixed_part",
    "frames_at",
    "infer_again",
    "noise_at",
    "of_one_kind",
    "of_press",
    "reading_sd",
]

CREEP = 3.0  # standard deviations by which older readings of a press must differ from newer ones to count as past
LEAST_TOUCHES = 2  # that say where the top stands without a force
FIXED, FRAME_NOISE = (
    3e-5,
    3e-4,
)  # m; what no averaging takes away of a height that is off by so much in one frame, or by more


class FirstTouch:
    """What was seen at a first touch: points (h, w, 3), m, membrane frame, valid and labels (h, w); no record prints it."""

    __slots__ = ("labels", "points", "valid")

    def __init__(self, points: FloatArray, valid: MaskArray, labels: LabelArray) -> None:
        self.points, self.valid, self.labels = points, valid, labels


@dataclass(frozen=True, slots=True)
class Reading:
    """The height of the top in so many frames averaged, at a stretch and a depth of the membrane.

    Of a first touch `touch` holds what was seen, `curvature`, 1/m, what its height was inferred with, `asked` whether the whole membrane was
    asked for it.
    """

    stretch: Length  # past the rest length
    depth: Length  # of the membrane
    height: Length  # of the top, world
    sd: Length  # standard deviation of height
    touch: FirstTouch | None = None
    frames: int = 1  # averaged
    fixed: Length = 0.0  # part of sd that no averaging takes away
    by_membrane: bool = False  # whether the whole membrane gave the height
    curvature: float | None = None
    asked: bool = False

    @property
    def alone(self) -> bool:
        """Whether the contact alone gave the height although the whole membrane was asked for it."""
        return self.asked and not self.by_membrane

    @property
    def hand(self) -> Length:
        """World height of the hand's flat membrane."""
        return self.height - self.depth


def infer_again(
    readings: Sequence[Reading],
    curvature: Estimate,
    hand: HandGeometry,
    mounting: Mounting | None,
    *,
    by_membrane: bool,
) -> list[Reading]:
    """Return the readings with the heights of first touches inferred again, now that the curvature of the top, 1/m, is known.

    `by_membrane` says whether the whole membrane gave the press: heights of two kinds do not go together.
    """
    return [
        reading
        if reading.touch is None or (reading.curvature, reading.asked) == (curvature.value, by_membrane)
        else _inferred(reading, reading.touch, curvature, hand, mounting, by_membrane=by_membrane)
        for reading in readings
    ]


def _inferred(
    reading: Reading,
    touch: FirstTouch,
    curvature: Estimate,
    hand: HandGeometry,
    mounting: Mounting | None,
    *,
    by_membrane: bool,
) -> Reading:
    top, whole = height_of_top(
        hand,
        mounting,
        touch.points,
        touch.valid,
        touch.labels,
        reading.stretch,
        curvature,
        by_membrane=by_membrane,
    )
    return replace(
        reading,
        depth=top.value,
        height=reading.hand + top.value,
        sd=top.sd,
        curvature=curvature.value,
        asked=by_membrane,
        by_membrane=whole,
    )


def of_one_kind(readings: list[Reading]) -> list[Reading]:
    """Return the readings without first touches that the contact alone gave where the whole membrane gave at least two others.

    The two kinds differ by some tenths of a millimetre over a top that flattens, which would be a part of the deflection.
    """
    kept = [reading for reading in readings if not reading.alone]
    return kept if sum(reading.touch is not None for reading in kept) >= LEAST_TOUCHES else readings


def of_press(readings: Sequence[Reading], latest: Reading) -> list[Reading]:
    """Return those of one press with the latest reading, which may be the last of them or come after them.

    A hand that went away and came back is at another press: it need not stand off as it did.
    """
    numbers = presses_of([*readings, latest])
    return [reading for reading, number in zip(readings, numbers, strict=False) if number == numbers[-1]]


def creep_of(press: Sequence[Reading], noise: float) -> tuple[Estimate, Sequence[Reading]]:
    """Return by how much the newer half of a press' readings stands above the older, m, and what of the older no longer counts.

    `noise` is the scatter of the readings over what they state.
    """
    if len(press) < 2:
        return Estimate(0.0, 0.0), []
    halves = press[: len(press) // 2], press[len(press) // 2 :]
    means = [sum(r.height for r in half) / len(half) for half in halves]
    sds = [math.hypot(*(r.sd for r in half)) / len(half) for half in halves]
    crept = Estimate(means[1] - means[0], noise * math.hypot(*sds))
    return crept, halves[0] if abs(crept.value) > CREEP * crept.sd else []


def frames_at(readings: Sequence[Reading], press: Reading) -> int:
    """Return how many frames the readings of a press hold together."""
    return sum(reading.frames for reading in of_press(readings, press))


def noise_at(readings: Sequence[Reading], press: Reading) -> tuple[Length, Length]:
    """Return by how much a height of a press is off in one frame, m, as its readings state it, and what of it more frames leave, m."""
    white = [max(r.sd**2 - r.fixed**2, 0.0) * r.frames for r in of_press(readings, press)]
    noise = math.sqrt(sum(white) / len(white))
    return noise, math.hypot(press.fixed, fixed_part(noise))


def reading_sd(stated: float, frames: int, frame_noise: float) -> float:
    """Return the sd of a height, m, seen in so many frames: as stated, or what a camera of such a noise leaves at least."""
    return max(stated, math.hypot(fixed_part(frame_noise), frame_noise / math.sqrt(frames)))


def fixed_part(frame_noise: Length) -> Length:
    """Return what no averaging takes away of a height that is off by so much in one frame, m."""
    return FIXED * min(frame_noise / FRAME_NOISE, 1.0)
