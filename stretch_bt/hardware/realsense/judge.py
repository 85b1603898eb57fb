"""Which frames of a camera are new and whole: the others are counted, and never given out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

__all__ = ["FrameCounters", "Judge", "TimedFrame"]

Counts = npt.NDArray[np.uint16]

#: rows of an image that are looked at together, and how many of their pixels must have a value for that
_BANDS, _ENOUGH = 16, 32
#: number of older frames in a row, and age of one, s, above which they mark a camera that began anew, not frames that were overtaken
_ANEW, _BACK = 10, 1.0
#: largest drift of a camera's clock against this machine's, and largest jump ahead at once, s
_DRIFT, _JUMP = 2e-4, 0.5
#: how long after the first frame, s, the quickest of all may still come, where the first ones were held up
_YOUNG = 2.0


@dataclass(frozen=True, slots=True)
class TimedFrame:
    """A frame: its number, the device's time of it, s, this machine's monotonic time when it came, s, and (h, w) counts.

    `exposed` is the monotonic time at which it would have come had it been as quick as the quickest.
    """

    number: int
    time: float
    arrived: float
    image: Counts
    exposed: float = 0.0


@dataclass(slots=True)
class FrameCounters:
    """How many frames came, and how many did not, or not as they should."""

    received: int = 0
    lost: int = 0
    late: int = 0
    repeated: int = 0
    stale: int = 0
    empty: int = 0
    torn: int = 0
    broken: int = 0


class Judge:
    """Looks at every frame of one camera, in the order in which they come.

    Parameters
    ----------
    lost_after
        Time without a good frame, s, after which it counts as an event that the camera was gone.
    noisy
        Whether no two images are alike, so that one that stands or is torn can be found.
    began
        Monotonic time of the begin, s.
    """

    def __init__(self, lost_after: float, noisy: bool, began: float) -> None:
        self.counters = FrameCounters()
        #: the mistake in the newest frame, and an event that somebody has to know, once
        self.bad: str | None = None
        self.event: str | None = None
        self._lost_after, self._noisy = lost_after, noisy
        self._good = began
        self._newest: TimedFrame | None = None
        self._seen: Counts | None = None
        self._older = 0
        self._floor: tuple[float, float] | None = None
        self._began = began
        #: when the first good frame came
        self._opened: float | None = None

    def silent(self, now: float) -> float:
        """Return how long no good frame came, s."""
        return now - self._good

    def excuse(self, seconds: float, now: float) -> None:
        """Take back some time until now, s, in which this machine did not look."""
        self._good = min(self._good + seconds, now)

    def take(self, shot: TimedFrame) -> TimedFrame | None:
        """Return a frame that is new and whole, with the time of its exposure; None for another."""
        self.counters.received += 1
        self.bad = self._out_of_order(shot) or self._incomplete(shot.image)
        if self.bad is not None:
            return None
        gone, self._good = shot.arrived - self._good, shot.arrived
        if self._opened is None:
            self._opened = shot.arrived
        elif gone > self._lost_after:
            self._note(f"no good frame came for {gone:.2g} s, and now they come again")
        return replace(shot, exposed=shot.arrived - self._lag(shot, self._opened))

    def _note(self, event: str) -> None:
        self.event = self.event or event

    def _out_of_order(self, shot: TimedFrame) -> str | None:
        last = self._newest
        if last is None:
            self._newest = shot
            return None
        ahead, later = shot.number - last.number, shot.time - last.time
        if ahead == 0:
            self.counters.repeated += 1
            return "it sends the same frame again and again"
        if ahead > 0 and later <= 0:
            self.counters.stale += 1
            self._newest = replace(last, number=shot.number)
            return "the time of its frames stands"
        if ahead < 0 and -_BACK < later <= 0 and self._older < _ANEW:
            self.counters.late += 1
            self._older += 1
            return "its frames come in the wrong order"
        if ahead < 0:
            self._note("the numbers of its frames went back: the camera was restarted")
            self._floor = None
        self.counters.lost += max(ahead - 1, 0)
        self._newest, self._older = shot, 0
        return None

    def _incomplete(self, image: Counts) -> str | None:
        """Return what is wrong with an image, by itself and beside the one before."""
        before, self._seen = self._seen, image
        if not image.any():
            self.counters.empty += 1
            return "no pixel of its images has a value"
        if before is None or not self._noisy:
            return None
        stands = [_stands(*bands) for bands in zip(_bands(before), _bands(image), strict=True)]
        told = [stood for stood in stands if stood is not None]
        if told and all(told):
            self.counters.stale += 1
            return "its image stands"
        if any(told):
            self.counters.torn += 1
            return "its images are torn"
        return None

    def _lag(self, shot: TimedFrame, opened: float) -> float:
        """Return how much longer a frame was on its way than the quickest, the first having come at `opened`, s; the camera's clock may drift."""
        way = shot.arrived - shot.time
        if self._floor is None:
            self._floor = (way, shot.arrived)
        least = self._floor[0] + _DRIFT * (shot.arrived - self._floor[1])
        if way < least - _JUMP - self._held(opened, shot.arrived):
            self._note(f"its clock jumped ahead by {least - way:.3g} s")
        self._floor = (min(least, way), shot.arrived)
        return way - self._floor[0]

    def _held(self, opened: float, now: float) -> float:
        """Return for how long the first frames may have been held up, as on a busy machine, while those that were not may yet come."""
        return opened - self._began if now - opened < _YOUNG else 0.0


def _bands(image: Counts) -> list[Counts]:
    return np.array_split(image, min(_BANDS, len(image)))


def _stands(before: Counts, now: Counts) -> bool | None:
    """Return whether part of an image is as it was, or gone; None where too few of its pixels had a value."""
    had = np.count_nonzero(before)
    if had < _ENOUGH:
        return None
    return not now.any() or np.array_equal(before, now)
