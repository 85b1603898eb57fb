"""Clauses for a depth camera, and for a force sensor."""

from __future__ import annotations

from typing import Any

import numpy as np

from stretch_bt.testing.contract.readings import ReadingClauses
from stretch_bt.testing.contract.trial import fault

__all__ = ["CameraClauses", "ForceClauses"]

_LOOK = 1.0


class CameraClauses(ReadingClauses):
    """Clauses on frames."""

    def test_frames_stay_as_they_were_given(self) -> None:
        """Nodes average frames and hand them on: a picture whose memory is used again changes under them."""
        trial = self.trial
        device = trial.open()
        kept: list[tuple[Any, Any, int]] = []
        for _ in trial.ticks(_LOOK):
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
            fault("the intrinsics of the device and those of its frame differ")


class ForceClauses(ReadingClauses):
    """Clauses on a force sensor."""

    def test_zero_takes_the_present_wrench_as_zero(self) -> None:
        """A task zeroes the sensor before it touches: what is left then is added to every force."""
        trial = self.trial
        device = trial.open()
        device.zero()
        trial.wait(0.1 + self.contract.latency)
        force = trial.read(device, "wrench").value.magnitude
        if force > self.contract.tolerance:
            fault(f"after zero() the sensor reads {force:.3g} N, at most {self.contract.tolerance:g} N allowed")
