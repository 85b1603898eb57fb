"""Which recorded item is the latest at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceLost

__all__ = ["Tape"]


class Tape:
    """Times of a recording, s, played from the moment of `start`; the last item stays for one more period."""

    def __init__(self, device: str, times: Any, now: Callable[[], float]) -> None:
        self.times: npt.NDArray[np.float64] = np.asarray(times, dtype=float)
        if self.times.size == 0:
            raise DeviceLost(device, "the recording is empty: it has no times")
        if self.times.ndim != 1 or not np.all(np.isfinite(self.times)):
            raise DeviceLost(device, "the times of the recording are not a list of finite numbers")
        if np.any(np.diff(self.times) <= 0):
            raise DeviceLost(device, "the times of the recording do not rise")
        self._device = device
        self._now = now
        self._start = now()
        period = float(np.median(np.diff(self.times))) if self.times.size > 1 else 0.0
        self._length = float(self.times[-1] - self.times[0]) + period

    @property
    def ended(self) -> bool:
        """Whether the last item has had its time."""
        return self._now() - self._start > self._length

    def latest(self) -> tuple[int, float]:
        """Return the number of the latest item and the host time at which it was due; raises DeviceLost at the end."""
        if self.ended:
            raise DeviceLost(self._device, "end of recording")
        elapsed = self._now() - self._start
        number = int(np.searchsorted(self.times - self.times[0], elapsed + 1e-9, side="right")) - 1
        return number, self._start + float(self.times[number] - self.times[0])
