"""Recorded rows of six numbers: position and rotation vector, or force and torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceLost, NotReady
from stretch_bt.hardware.replay.npz import read_arrays
from stretch_bt.hardware.replay.tape import Tape

__all__ = ["Sixes", "opened"]

_Three = tuple[float, float, float]


class Sixes:
    """Arrays (n, 6) of a file by name, played together from the moment of the start; raises DeviceLost where they are none."""

    def __init__(self, device: str, path: Path, time: str, keys: Sequence[str], now: Callable[[], float]) -> None:
        found = read_arrays(device, path, [*keys, time])
        self.tape = Tape(device, found[time], now)
        self._arrays: dict[str, npt.NDArray[Any]] = {key: found[key] for key in keys}
        for key, array in self._arrays.items():
            if array.shape != (self.tape.times.size, 6) or not np.all(np.isfinite(array)):
                told = f"{key} must be ({self.tape.times.size}, 6) and finite, it is {array.shape}"
                raise DeviceLost(device, told)

    def latest(self, key: str) -> tuple[_Three, _Three, float, float, int]:
        """Return both halves of the latest row, its time in the recording, s, the host time at which it was due, and its number.

        Raises
        ------
        DeviceLost
            The recording is at its end.
        """
        number, due = self.tape.latest()
        a, b, c, d, e, f = (float(v) for v in self._arrays[key][number])
        return (a, b, c), (d, e, f), float(self.tape.times[number]), due, number


def opened(device: str, played: Sixes | None) -> Sixes:
    """Return a recording that is played; raises NotReady where none is."""
    if played is None:
        raise NotReady(device, "the recording is not open")
    return played
