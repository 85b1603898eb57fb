"""The static error of a depth camera, pixel by pixel, learned from frames of the free membrane."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_estimates, check_kind, check_numbers
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.average import check_one_hand, in_finer_unit
from stretch_bt.perception.deprojection import ray_table
from stretch_bt.perception.mask import LARGEST
from stretch_bt.perception.smooth import smooth
from stretch_bt.perception.types import FRAME, MADE, Contact, MaskArray
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Estimate, Length, Speed, Time

__all__ = ["HANG", "FreeView", "Pattern", "with_left_over", "without_pattern"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]

KERNEL = 6.0  # pixels; a static error is smoother than that, and noise that frames did not average out is not
DELAY = 15  # latest frames that are left out, as a press may have begun in them
DRIFT = 4e-6  # m/s; standard deviation of how fast depth drifts over cameras: a quarter of a millimetre a minute
LEAST_MEANS = 30  # fewest frames that show a drift
LEARNED = "`FreeView.pattern` makes one"
SEEN = 0.5  # share of the frames in which a pixel must be valid
#: m; prior of the sag of a silicone membrane in its middle, where nothing more is known of it
HANG = Estimate(3e-4, 3e-4)
SIDES = 0.13  # how much lower the free sides hang, over the sag in the middle: of solved sheets 90 mm wide
FAR = 2.0  # standard deviations that a static error adds to a sag, past which a membrane hangs by far more or less
PART = 0.7  # standard deviation that a static error adds to a sag fitted to it, over its own


@dataclass(frozen=True, slots=True, repr=False)
class Pattern(BriefRepr):
    """Static error of a camera's depth, learned from frames of the free membrane, whose sag is no error."""

    error: Image  # (h, w) float32, m, 0 where unknown
    hung: Image  # (h, w) float32, m, how far below the flat membrane each place of it hung meanwhile
    left: Length  # about the standard deviation of the part that `error` misses
    hang: Length  # sag of the middle of the membrane, as estimated
    hang_sd: Length  # standard deviation of hang, and of heights in the world
    rate: Speed  # speed at which depth grew as the camera warmed
    time: Time  # time of the camera at which the error was so
    stretch: Length | None = None  # stretch of the membrane meanwhile
    camera: str = ""  # name of the camera in the task, where it is known


class FreeView:
    """Mean of frames of the free membrane, from which the static error of the camera follows.

    A membrane in tension is flat but for the sag under its own weight: a parabola from clamp to clamp, a little lower at its free
    sides. The residual of the mean to the plane and that shape is the camera's error. The sag cannot be distinguished from a static error
    of the same shape. Its estimate is a least-squares fit weighted with a prior; the residual gives the variance of the fit. A membrane
    that hangs by far more or less than the prior is believed as it is seen. Under a press a membrane no longer hangs, so that its
    sag must not be subtracted with the error. The change of the mean depth from frame to frame shows how fast the
    camera drifts.
    """

    def __init__(self) -> None:
        self._latest: deque[DepthFrame] = deque()
        self._first: DepthFrame | None = None
        self._total: npt.NDArray[np.uint32] = np.zeros((0, 0), dtype=np.uint32)
        self._seen: npt.NDArray[np.uint32] = np.zeros((0, 0), dtype=np.uint32)
        self._means: list[tuple[float, float]] = []  # time, s, and mean depth, m
        self.count = 0

    def add(self, frame: DepthFrame) -> None:
        """Take a frame; it counts once fifteen more have come.

        Raises
        ------
        InvalidInput
            The frames differ in unit, intrinsics, stretch or the distance of the plane.
        """
        check_kind("frame", frame, DepthFrame, FRAME)
        first = self._first = self._first or frame
        if frame.unit != first.unit:
            raise InvalidInput("a free view needs frames of one camera: their unit or intrinsics differ")
        check_one_hand("free view", frame, first)
        self._latest.append(frame)
        if len(self._latest) > DELAY:
            self._count(self._latest.popleft())

    def settle(self) -> None:
        """Count the latest frames as well: they are known to be of the free membrane."""
        while self._latest:
            self._count(self._latest.popleft())

    def _count(self, frame: DepthFrame) -> None:
        if not self.count:
            self._total = np.zeros(frame.raw.shape, dtype=np.uint32)
            self._seen = np.zeros(frame.raw.shape, dtype=np.uint32)
        self._total += frame.raw
        self._seen += frame.raw > 0
        self.count += 1
        seen = int(np.count_nonzero(frame.raw))
        if seen:
            self._means.append((frame.time, float(frame.raw.sum(dtype=np.uint64)) / seen * frame.unit))

    def pattern(self, gauge: float, hang: Estimate = HANG, width: float = math.inf) -> Pattern | None:
        """Return the static error that the frames so far show, for a membrane with the prior `hang` of the sag in its middle, m.

        `gauge`, m, is its length from clamp to clamp at stretch 0, and `width`, m, its size across, where it is known.

        None where no frame counts yet, or they do not say how far the flat membrane is or show nothing.

        Raises
        ------
        InvalidInput
            A length is no number above 0, or `hang` carries no standard deviation or is not finite.
        """
        _check_membrane(gauge, hang, width)
        frame, known = self._first, self._seen > SEEN * self.count
        if frame is None or frame.plane_distance is None or not self.count or not known.any():
            return None
        _check_apart(gauge, frame.stretch or 0.0)
        depth = self._total / np.maximum(self._seen, 1) * frame.unit
        deeper, weight = (depth - frame.plane_distance).astype(np.float32), known.astype(np.float32)
        once, cover = smooth(deeper, weight, KERNEL)
        # The mean of the residual shows the part of a bent surface that a mean misses (Tukey's twicing).
        again, _ = smooth(deeper - once, weight, KERNEL)
        error, left = once + again, float(np.sqrt(np.mean(again[known] ** 2)))
        across, along = np.moveaxis(ray_table(frame.intrinsics)[..., :2] * frame.plane_distance, 2, 0)
        shape = np.maximum(1.0 - (2.0 * along / (gauge + (frame.stretch or 0.0))) ** 2, 0.0)
        shape = (shape * (1.0 + SIDES * np.minimum(np.abs(2.0 * across / width), 1.0) ** 2)).astype(np.float32)
        hung = _hang(error, shape, known, hang)
        rate, time = _drift(np.array(self._means))
        below = np.float32(hung.value) * shape
        return Pattern(
            np.where(cover > 1e-3, error - below, np.float32(0)),
            below,
            left,
            hung.value,
            hung.sd,
            rate,
            time,
            frame.stretch,
        )


def _check_apart(gauge: float, stretch: float) -> None:
    if not gauge + stretch > 0:
        raise InvalidInput(
            f"gauge and the stretch of the frames together are above 0 m, not {gauge:g} and {stretch:g}; give both in m"
        )


def _check_membrane(gauge: float, hang: Estimate, width: float) -> None:
    check_numbers("in m", gauge=gauge)
    check_estimates(hang=hang)
    if not 0 < gauge <= LARGEST:
        raise InvalidInput(
            f"gauge, from clamp to clamp, is above 0 m and at most {LARGEST:g} m, not {gauge:g}; write 0.1 for 100 mm"
        )
    if width != math.inf and not (is_number(width) and width > 0):
        raise InvalidInput(f"width is a length above 0 m, or math.inf where it is not known, not {shown(width)[:80]}")


def _hang(error: Image, shape: Image, known: MaskArray, told: Estimate) -> Estimate:
    """Return the sag, m, of a membrane that seems to lie deeper by `error`, m, than flat, with `told` as the prior of its sag."""
    e, b = error[known].astype(np.float64), shape[known].astype(np.float64)
    fitted = float(e @ b) / max(float(b @ b), 1e-12)
    variance = PART**2 * float(np.mean((e - fitted * b) ** 2))
    # one that hangs by far more or less is no such membrane, and is believed as it is seen
    prior = max(told.sd**2, (fitted - told.value) ** 2 - FAR**2 * variance, 1e-16)
    hang = max((fitted * prior + told.value * variance) / (prior + variance), 0.0)
    return Estimate(hang, math.sqrt(variance * prior / (prior + variance)))


def _drift(means: Array) -> tuple[float, float]:
    """Return how fast depth grows, m/s, by the slope of its mean (time, depth) (n, 2), and the middle of the times.

    The slope is drawn to 0, the more the larger its variance is against the one of cameras' drifts; successive means share noise.
    """
    time, depth = means[:, 0] - means[:, 0].mean(), means[:, 1] - means[:, 1].mean()
    spread = float(time @ time)
    if len(means) < LEAST_MEANS or spread == 0.0:
        return 0.0, float(means[:, 0].mean())
    slope = float(time @ depth) / spread
    left = depth - slope * time
    power = float(left @ left)
    shared = float(np.clip(left[1:] @ left[:-1] / power, 0.0, 0.95)) if power > 0.0 else 0.0
    variance = power / (len(means) - 2) * (1.0 + shared) / (1.0 - shared) / spread
    return slope * DRIFT**2 / (DRIFT**2 + variance), float(means[:, 0].mean())


def with_left_over(contact: Contact, pattern: Pattern) -> Contact:
    """Return a contact whose noise includes the error that a pattern missed: the whole contact may share it.

    Both errors make the noise of a pixel, and `noise_area` keeps the variance of a mean over the contact the sum of theirs.
    """
    check_kind("contact", contact, Contact, MADE)
    check_kind("pattern", pattern, Pattern, LEARNED)
    own, left = contact.noise**2, pattern.left**2
    if not left:
        return contact
    area = (own * contact.noise_area + left * len(contact.points)) / (own + left)
    return replace(contact, noise=math.sqrt(own + left), noise_area=max(area, 1.0))


def without_pattern(frame: DepthFrame, pattern: Pattern) -> DepthFrame:
    """Return a frame without the static error of its camera and its drift since then, as a frame of a finer unit.

    Pixels that are far behind the hand may become invalid, as in `average_frames`.

    Raises
    ------
    InvalidInput
        The frame is of another shape than the pattern.
    """
    check_kind("frame", frame, DepthFrame, FRAME)
    check_kind("pattern", pattern, Pattern, LEARNED)
    if frame.raw.shape != pattern.error.shape:
        raise InvalidInput(f"the pattern is of images of shape {pattern.error.shape}, got {frame.raw.shape}")
    error = pattern.error + np.float32(pattern.rate * (frame.time - pattern.time))
    return in_finer_unit(frame, np.where(frame.raw > 0, frame.raw - error / np.float32(frame.unit), np.float32(0)))
