"""A moving average of wrenches: a CB3's force is noise of several newtons in each sample, and its mean is not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from stretch_bt.hardware.ur.messages import Six

__all__ = ["ForceFilter", "HandForce"]

#: a sample whose time is rounded counts as old as it is
_ROUNDING = 1e-6
#: how old a sample may be, s, that stands in for one that did not come: as long as an arm may be silent at most
_OLDEST = 2.0


@dataclass(frozen=True, slots=True)
class HandForce:
    """Force on the hand, N: averaged, and of the latest sample alone."""

    average: float
    sample: float


@dataclass(frozen=True, slots=True)
class ForceFilter:
    """The samples of the latest `over` seconds, each with the controller's time of it, s.

    Where samples did not come, older ones stay, up to `count` and 2 s: a mean of the few that came would be noise, and nodes
    receive it. Limits go by the samples of `over` alone, or they would see a force that rises too late.
    """

    over: float
    count: int
    samples: tuple[tuple[float, Six], ...] = ()

    def take(self, time: float, wrench: Six) -> ForceFilter:
        """Return the filter with one more sample; those that are too old, or of a clock that went back, are gone."""
        known = [sample for sample in self.samples if time - _OLDEST < sample[0] < time]
        count = max(len(self._recent(known, time)), self.count - 1)
        kept = known[max(len(known) - count, 0) :]
        return replace(self, samples=(*kept, (time, wrench)))

    def less(self, zero: Six) -> Six:
        """Return the mean wrench, less a zero."""
        mean = np.mean([wrench for _, wrench in self.samples], axis=0) - zero
        return cast(Six, tuple(mean.tolist()))

    def force(self, zero: Six) -> HandForce:
        """Return the force of the mean wrench of the latest `over` seconds and of the latest sample, each less a zero."""
        time, latest = self.samples[-1]
        recent = np.mean(self._recent(self.samples, time), axis=0)
        average, sample = (float(np.linalg.norm(np.subtract(felt, zero)[:3])) for felt in (recent, latest))
        return HandForce(average, sample)

    def anew(self) -> ForceFilter:
        """Return the filter with its latest sample alone, which it cannot do without."""
        return replace(self, samples=self.samples[-1:])

    def _recent(self, samples: Iterable[tuple[float, Six]], time: float) -> list[Six]:
        """Return the wrenches of the `over` seconds before a time."""
        return [wrench for at, wrench in samples if time - self.over + _ROUNDING < at]
