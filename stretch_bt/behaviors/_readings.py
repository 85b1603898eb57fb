"""Readings of the height of an object's top since it was approached."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stretch_bt.behaviors._membrane import height_of_top
from stretch_bt.model.palpation.balance import presses_of
from stretch_bt.perception.types import FloatArray, LabelArray, MaskArray
from stretch_bt.units import Estimate, Length

if TYPE_CHECKING:
    from stretch_bt.behaviors.records import Mounting
    from stretch_bt.hardware.hand import HandGeometry
    from stretch_bt.model.palpation.series import Series

__all__ = [
    "FirstTouch",
    "Reading",
    "fixed_part",
    "frames_at",
    "infer_again",
    "noise_at",
    "of_one_kind",
    "of_press",
    "reading_sd",
    "without_crept",
]

CREEP = 3.0  # least difference of a press' older readings from its newer ones, in standard deviations, for the older to count as past
FEW = 2  # degrees of freedom of the scatter of a press' readings, from which on it is known
LEAST_TOUCHES = 2  # least number of touches that give the height of the top at no force
FIXED, FRAME_NOISE = (
    3e-5,
    3e-4,
)  # m; part of a height's error that no averaging takes away, where its standard deviation in one frame is FRAME_NOISE or more


class FirstTouch:
    """A first touch as the camera saw it: points (h, w, 3), m, membrane frame, valid and labels (h, w); no record prints it."""

    __slots__ = ("labels", "points", "valid")

    def __init__(self, points: FloatArray, valid: MaskArray, labels: LabelArray) -> None:
        self.points, self.valid, self.labels = points, valid, labels


@dataclass(frozen=True, slots=True)
class Reading:
    """The height of the top, averaged over `frames`, at a stretch and a depth of the membrane.

    Of a first touch `touch` holds the points seen, `curvature`, 1/m, is the one that its height was inferred with, and `asked` says whether the
    whole membrane was asked for it.
    """

    stretch: Length  # stretch past the rest length
    depth: Length  # depth of the membrane
    height: Length  # height of the top, world
    sd: Length  # standard deviation of height
    touch: FirstTouch | None = None
    frames: int = 1  # number of frames averaged
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

    `by_membrane` says whether the whole membrane gave the height at the press: heights of two kinds do not go together.
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
    """Return the readings without first touches given by the contact alone, where the whole membrane gave at least two other first touches.

    The two kinds differ by some tenths of a millimetre over a top that flattens, which would be a part of the deflection.
    """
    kept = [reading for reading in readings if not reading.alone]
    return kept if sum(reading.touch is not None for reading in kept) >= LEAST_TOUCHES else readings


def of_press(readings: Sequence[Reading], latest: Reading) -> list[Reading]:
    """Return the readings of the same press as the latest reading, which may be the last of them or come after them.

    A hand that went away and came back is at another press: its positioning error may have changed.
    """
    numbers = presses_of([*readings, latest])
    return [reading for reading, number in zip(readings, numbers, strict=False) if number == numbers[-1]]


def without_crept(
    readings: list[Reading], fit: Callable[[list[Reading]], Series]
) -> tuple[list[Reading], Series, Estimate]:
    """Return the readings that count, their fit, and how far the newer half of the latest press' readings stands above the older half, m.

    The older half no longer counts where the press creeps for certain.
    """
    series, press = fit(readings), of_press(readings, readings[-1])
    halves = press[: len(press) // 2], press[len(press) // 2 :]
    if not halves[0]:
        return readings, series, Estimate(0.0, 0.0)
    creep = _creep(halves, series.chi2)
    if abs(creep.value) <= CREEP * creep.sd:
        return readings, series, creep
    past = {id(reading) for reading in halves[0]}
    left = [reading for reading in readings if id(reading) not in past]
    return left, fit(left), creep


def _creep(halves: Sequence[Sequence[Reading]], chi2: float) -> Estimate:
    """Return how far the second half of a press' readings stands above the first, m; `chi2` is of the fit to all."""
    means = [sum(r.height for r in half) / len(half) for half in halves]
    sds = [math.hypot(*(r.sd for r in half)) / len(half) for half in halves]
    free = sum(map(len, halves)) - len(halves)
    if free >= FEW:  # creep, which scatters the readings of all, is none within the halves
        pairs = zip(halves, means, strict=True)
        chi2 = sum(((r.height - mean) / r.sd) ** 2 for half, mean in pairs for r in half) / free
    noise = math.sqrt(max(chi2, 1.0))  # ratio of the readings' scatter to the standard deviations that they state
    return Estimate(means[1] - means[0], noise * math.hypot(*sds))


def frames_at(readings: Sequence[Reading], press: Reading) -> int:
    """Return the number of frames in all readings of a press together."""
    return sum(reading.frames for reading in of_press(readings, press))


def noise_at(readings: Sequence[Reading], press: Reading) -> tuple[Length, Length]:
    """Return the standard deviation of a press' height in one frame, m, as its readings state it, and the part that more frames do not reduce, m."""
    white = [max(r.sd**2 - r.fixed**2, 0.0) * r.frames for r in of_press(readings, press)]
    noise = math.sqrt(sum(white) / len(white))
    return noise, math.hypot(press.fixed, fixed_part(noise))


def reading_sd(stated: float, frames: int, frame_noise: float) -> float:
    """Return the sd of a height averaged over `frames`, m: as stated, but at least the sd that a camera with `frame_noise`, m, allows."""
    return max(stated, math.hypot(fixed_part(frame_noise), frame_noise / math.sqrt(frames)))


def fixed_part(frame_noise: Length) -> Length:
    """Return the part of a height's error that no averaging takes away, m, from its standard deviation in one frame, m."""
    return FIXED * min(frame_noise / FRAME_NOISE, 1.0)
