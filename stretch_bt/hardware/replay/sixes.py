"""Recorded rows of six numbers: position and rotation vector, or force and torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import DeviceLost, NotReady
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import Driver
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.replay.npz import read_arrays
from stretch_bt.hardware.replay.tape import Tape

__all__ = ["PlaysSixes", "Sixes"]

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


class PlaysSixes(Driver):
    """A driver that plays recorded rows from the moment it is opened; its options name the file and the times in it."""

    any_clock = True
    _played: Sixes | None = None

    @property
    def ended(self) -> bool:
        """Whether the last row has had its time."""
        return self._played is not None and self._played.tape.ended

    def close(self) -> None:
        """Forget where it stood."""
        self._played = None

    def play(self, *keys: str) -> None:
        """Read the arrays of these names and begin to play them."""
        self._played = Sixes(self.name, self.cell.root / self.options.file, self.options.time, keys, self.cell.now)

    def latest_pose(self) -> Reading[Pose]:
        """Return the latest recorded pose; raises NotReady before `play`, DeviceLost at the end of the recording."""
        position, rotation, time, due, number = self._opened().latest(self.options.pose)
        return Reading(Pose(position, rotation), time, due, number)

    def latest_wrench(self) -> Reading[Wrench]:
        """Return the latest recorded wrench; raises as `latest_pose`."""
        force, torque, time, due, number = self._opened().latest(self.options.wrench)
        return Reading(Wrench(force, torque), time, due, number)

    def _opened(self) -> Sixes:
        if self._played is None:
            raise NotReady(self.name, "the recording is not open")
        return self._played
