"""Clauses for a depth camera, and for a force sensor."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from stretch_bt.frames import Wrench
from stretch_bt.testing.contract.readings import ReadingClauses
from stretch_bt.testing.contract.trial import fault

__all__ = ["CameraClauses", "ForceClauses"]

#: for how long frames are kept, s, and how many greatest ages of a slow camera
_LOOK, _AGES = 1.0, 3.0
#: longest time until a load shows in a reading, and how long it stands before it is taken as zero, s
_LOADING, _STANDING = 3.0, 0.5


class CameraClauses(ReadingClauses):
    """Clauses on frames."""

    def test_frames_stay_as_they_were_given(self) -> None:
        """Nodes average frames and hand them on: a picture whose memory is used again changes under them."""
        trial = self.trial
        device = trial.open()
        kept: list[tuple[Any, Any, int]] = []
        for _ in trial.ticks(max(_LOOK, _AGES * self.contract.latency)):
            if trial.over(device):
                break
            reading = trial.read(device, "frame")
            if not kept or kept[-1][2] != reading.sequence:
                kept.append((reading.value.raw, np.array(reading.value.raw), reading.sequence))
        for raw, copy, number in kept[:-1]:
            if not np.array_equal(raw, copy):
                fault(
                    f"frame {number} changed after it was given: the driver fills the same memory again; give each frame an array of its own"
                )

    def test_frames_say_what_their_readings_say(self) -> None:
        """Whoever has a frame alone, as a record or a node, takes its time and number from it."""
        device = self.trial.open()
        reading = self.trial.read(device, "frame")
        frame = reading.value
        if frame.sequence != reading.sequence:
            fault(f"frame.sequence is {frame.sequence}, the number of its reading {reading.sequence}")
        if frame.time not in (reading.device_time, reading.host_time):
            fault(
                f"frame.time is {frame.time:.3f} s, its reading has {reading.device_time:.3f} s by the device's clock"
            )
        if device.intrinsics != frame.intrinsics:
            fault("the intrinsics of the device and of its frame differ")


class ForceClauses(ReadingClauses):
    """Clauses on a force sensor."""

    def test_zero_takes_the_present_wrench_as_zero(self) -> None:
        """A task zeroes the sensor before it touches: a residual is then added to every force."""
        trial, most = self.trial, self.contract.tolerance
        device = trial.open()
        before = trial.read(device, "wrench").value
        if self.contract.load is not None:
            before = self._loaded(device, before)
        device.zero()
        first = trial.read(device, "wrench").value.magnitude
        trial.wait(0.1 + self.contract.latency)
        force = trial.read(device, "wrench").value.magnitude
        if force > most:
            fault(f"after zero() the sensor reads {force:.3g} N, at most {most:g} N allowed")
        if first > most:
            fault(
                f"the first reading after zero() is {first:.3g} N, at most {most:g} N allowed, and a later one {force:.3g} N: it is an old "
                "one; return from zero() only when the newest sample is from after it"
            )
        if before.magnitude <= most:
            pytest.skip(
                f"what zero() does cannot be seen: the sensor read {before.magnitude:.3g} N before it; put more than {most:g} N on it by `load`"
            )

    def _loaded(self, device: Any, before: Wrench) -> Wrench:
        """Put a load on the sensor, and return what it reads once that stands."""
        trial, most = self.trial, self.contract.tolerance
        trial.put_load(device)
        wrench, seen = before, {(before.force, before.torque)}
        for _ in trial.ticks(_LOADING + self.contract.latency):
            wrench = trial.read(device, "wrench").value
            seen.add((wrench.force, wrench.torque))
            if math.dist(wrench.force, before.force) > 2 * most:
                break
        else:
            what = f"the sensor reads {wrench.magnitude:.3g} N before its load and under it"
            if len(seen) == 1:
                fault(f"{what}, alike to the last digit: it repeats one value for ever, whatever it measures")
            fault(f"{what}, less than {2 * most:g} N apart: let it give newtons, and put on a larger `load`")
        trial.wait(_STANDING + self.contract.latency)
        loaded: Wrench = trial.read(device, "wrench").value
        return loaded
