"""Clauses on the readings of a device: numbers, times, ages and units."""

from __future__ import annotations

import math
import statistics
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from stretch_bt.errors import StretchError
from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.testing.contract.life import LifeClauses
from stretch_bt.testing.contract.trial import fault

__all__ = ["ReadingClauses"]

#: for how long readings are looked at from the moment of opening, s: a queue that grows is late by then
_LOOK = 1.6
#: the same for a slower device, in its greatest ages
_AGES = 3.0
#: how long a tick may wait for one reading, s, of its 20 ms; more where the machine is busy
_QUICK = 0.03
_FEWEST = 5
_LONGEST_OPENING, _FARTHEST, _STRONGEST = 1.0, 20.0, 1e4
#: depths of a picture, m
_NEAREST_DEPTH, _FARTHEST_DEPTH = 0.005, 20.0


@dataclass(frozen=True, slots=True)
class _Seen:
    """A reading, when it was read, and how long that took, s."""

    reading: Reading[Any]
    at: float
    took: float


class ReadingClauses(LifeClauses):
    """Clauses for what every device can be asked for."""

    def test_readings_are_quick(self) -> None:
        """A tree ticks every 20 ms and reads in that time: whoever waits for the device there delays the safe stop."""
        if self.trial.virtual is not None:
            pytest.skip("its clock waits for it")
        for name, seen in self._looked().items():
            took = statistics.median(s.took for s in seen)
            if took > _QUICK:
                fault(
                    f"{name}() takes {1e3 * took:.0f} ms, at most {1e3 * _QUICK:.0f} ms allowed: "
                    "read in a thread of its own, such as WireThread, and return the latest sample"
                )

    def test_numbers_grow_with_new_readings(self) -> None:
        """Nodes wait for a new number before they take a reading as new, and take equal numbers for one and the same reading."""
        for name, seen in self._looked().items():
            numbers = [s.reading.sequence for s in seen]
            if any(b < a for a, b in pairwise(numbers)):
                fault(f"the numbers of {name}() fall from one reading to the next; number each new one higher")
            look = self._look
            whole = seen[-1].at - seen[0].at > 0.8 * look  # a recording may end before
            # a reading that may be so old need not come more often
            if whole and len(set(numbers)) < min(_FEWEST, int(look / self.contract.latency)):
                fault(
                    f"{name}() gave only {len(set(numbers))} new numbers in {look:.2g} s: "
                    "give each new reading a higher number, or read the device more often"
                )
            for one, other in pairwise(seen):
                _same_or_new(name, one.reading, other.reading)

    def test_readings_are_as_old_as_they_say(self) -> None:
        """A hand that presses goes by what it sees now: an old reading with a new time presses too deep, and no limit of age finds it."""
        latency = self.contract.latency
        for name, seen in self._looked().items():
            ahead = max(s.reading.host_time - s.at for s in seen)
            if ahead > 1e-6:
                fault(
                    f"the host time of {name}() is {ahead:.3g} s in the future: it is the time now(), s, at which the value was taken"
                )
            if (age := statistics.median(s.at - s.reading.host_time for s in seen)) > latency:
                fault(f"{name}() is {age:.2g} s old, at most {latency:g} s allowed: read the device more often")
            self._by_its_own_clock(name, seen)

    def test_values_are_in_si_units(self) -> None:
        """Numbers carry no unit inside: millimetres where metres are meant are a thousand times too far."""
        for name, seen in self._looked().items():
            for one in seen:
                _judge(name, one.reading.value)

    @property
    def _look(self) -> float:
        """For how long readings are looked at, s."""
        return max(_LOOK, _AGES * self.contract.latency)

    def _by_its_own_clock(self, name: str, seen: list[_Seen]) -> None:
        """Compare the device's clock with the host's; the reading that is least late gives their difference."""
        latency = self.contract.latency
        least = min(s.at - s.reading.device_time for s in seen)
        last = seen[2 * len(seen) // 3 :]  # a queued reading is late for good, one that a busy machine delays is not
        late = statistics.median(s.at - s.reading.device_time for s in last) - least
        if late > latency:
            said = statistics.median(s.at - s.reading.host_time for s in last)
            fault(
                f"the readings of {name}() from t = {last[0].at - seen[0].at:.2f} s on are {late:.2g} s old by the device's own clock and "
                f"say {max(said, 0.0):.2g} s, at most {latency:g} s allowed: readings are stamped when read, not when taken, "
                "or wait in a queue; give the newest, with the time at which it was taken"
            )

    def _looked(self) -> dict[str, list[_Seen]]:
        """Open the device and read all it has for a while; the clauses share what was read."""
        if self.contract.looked:
            return self.contract.looked
        trial = self.trial
        device = trial.open()
        found: dict[str, list[_Seen]] = {name: [] for name in trial.readings}
        for _ in trial.ticks(self._look):
            for name, seen in found.items():
                begun = time.perf_counter()
                try:
                    reading = trial.read(device, name)
                except StretchError as error:
                    if trial.over(device):
                        break
                    fault(f"{name}() raises {type(error).__name__} although the device is well: {error}")
                seen.append(_Seen(reading, trial.now(), time.perf_counter() - begun))
        for name, seen in found.items():
            if not seen:
                fault(f"{name}() gave no reading")
        self.contract.looked.update(found)
        return found


def _same_or_new(name: str, one: Reading[Any], other: Reading[Any]) -> None:
    """Compare two readings that follow each other."""
    if one.sequence == other.sequence:
        if (one.host_time, one.device_time) != (other.host_time, other.device_time):
            fault(
                f"{name}() gave the number {one.sequence} twice with times {abs(other.host_time - one.host_time):.3g} s apart: "
                "readings are stamped when read, not when taken"
            )
    elif other.device_time <= one.device_time or other.host_time < one.host_time:
        fault(f"{name}() gave new readings whose times do not rise: give each the time at which it was taken, s")


def _judge(name: str, value: Any) -> None:
    if isinstance(value, DepthFrame):
        _judge_frame(value)
    elif isinstance(value, Pose):
        if (far := math.hypot(*value.position)) > _FARTHEST:
            fault(f"{name}() is {far:.3g} m from the origin: positions are in metres")
    elif isinstance(value, Wrench):
        if not value.magnitude < _STRONGEST:
            fault(f"{name}() is {value.magnitude:.3g} N: forces are finite and in newtons")
    elif not isinstance(value, float | int | np.floating):
        fault(f"{name}() gave a {type(value).__name__}")
    elif not 0 <= value <= _LONGEST_OPENING:
        fault(f"{name}() gave {value:.4g}: openings are in metres, from 0 to {_LONGEST_OPENING:g} m")


def _judge_frame(frame: DepthFrame) -> None:
    lens, raw = frame.intrinsics, np.asarray(frame.raw)
    if raw.dtype != np.uint16:
        fault(f"the picture of frame() has {raw.dtype} pixels: raw are counts, uint16, and `unit` the length of one, m")
    if raw.shape != (lens.height, lens.width):
        fault(
            f"the picture of frame() has {raw.shape[0]} rows of {raw.shape[1]} pixels, its intrinsics {lens.height} rows of {lens.width}: "
            "pictures are indexed [row, column]"
        )
    if not raw.any():
        fault("no pixel of frame() has a depth; 0 stands for a pixel without one")
    depth = frame.unit * float(np.median(raw[raw > 0]))
    if not _NEAREST_DEPTH < depth < _FARTHEST_DEPTH:
        fault(
            f"the median depth of frame() is {depth:.3g} m: `unit` is the length of one count, m, 0.001 for millimetres"
        )
    if not (0 <= lens.cx < lens.width and 0 <= lens.cy < lens.height and lens.fx > 0 and lens.fy > 0):
        fault("the intrinsics of frame() are no pinhole: cx and cy are pixels inside of the picture, fx and fy above 0")
