"""Clauses on a connection that breaks."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import pytest

from stretch_bt.errors import DeviceFault, NotReady, StaleReading, StretchError, named
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.testing.contract.motion import MotionClauses
from stretch_bt.testing.contract.readings import ReadingClauses
from stretch_bt.testing.contract.trial import distance, fault

__all__ = ["CutClauses", "CutMotionClauses"]

#: how long a loss may stay unnoticed, s, besides the latency; how long closing may take after it
_NOTICED, _CLOSING = 3.0, 5.0
_AFTER = 1.0
#: for how long a motion still goes on, at least, as its connection is cut, s
_CUTTING = 0.5


class CutClauses(ReadingClauses):
    """Clauses for a device whose connection the test can break."""

    needs: ClassVar[tuple[str, ...]] = ("cut",)

    def test_a_loss_is_a_fault_that_stays(self) -> None:
        """Nothing may go on with readings from before a loss, and nothing moves again by itself after one: a person has looked in between."""
        trial = self.trial
        device = trial.open()
        name = trial.readings[0]
        trial.read(device, name)
        trial.break_connection()
        self._lost(device, name)
        if device.state is not DeviceState.FAULT:
            fault(f"after the loss the device is {device.state}, not in fault: raise DeviceLost, which stays")
        for _ in trial.ticks(_AFTER):
            try:
                trial.read(device, name)
            except StretchError:
                continue
            fault(
                f"{name}() gives readings again after the loss: it reconnected by itself; raise DeviceLost until it is opened anew"
            )
        _close(device)

    def _lost(self, device: Any, name: str) -> None:
        """Wait until a reading says that the device is lost."""
        trial, last = self.trial, None
        for _ in trial.ticks(_NOTICED + self.contract.latency):
            try:
                last = trial.read(device, name)
            except StaleReading as stale:
                fault(
                    f"after the connection broke {name}() says only that it is stale ({stale.reason}); raise DeviceLost"
                )
            except DeviceFault as error:
                if "driver broke" in error.reason:
                    fault(f"after the connection broke the {error.reason}; raise DeviceLost")
                return
        age = trial.now() - last.host_time if last is not None else 0.0
        what = (
            f"the same reading, {age:.1f} s old"
            if age > self.contract.latency
            else "new readings: it reconnected by itself"
        )
        fault(f"{_NOTICED:g} s after the connection broke {name}() still gives {what}; raise DeviceLost, once for all")


class CutMotionClauses(CutClauses, MotionClauses):
    """The same of a device that moves."""

    needs: ClassVar[tuple[str, ...]] = ("moves", "cut")

    def test_a_loss_during_a_motion_is_told(self) -> None:
        """The node that waits for the motion must learn that nobody knows where the device is; DONE or a motion without end hide it."""
        trial = self.trial
        device, home = self._at_home()
        left = 2 / 3 * distance(home, self._target)
        motion = self._begin(device, min(self.trial.speed, left / _CUTTING))
        self._underway(device, home, motion)
        trial.break_connection()
        state = MotionState.MOVING
        for passed in trial.ticks(_NOTICED + self.contract.latency):
            try:
                state = motion.poll()
            except DeviceFault as error:
                if "driver broke" in error.reason:
                    fault(f"after the connection broke the {error.reason}; raise DeviceLost")
                break
            if state is not MotionState.MOVING:
                fault(
                    f"{passed:.1f} s after the connection broke the motion is {state}: nobody knows that; raise DeviceLost"
                )
        else:
            fault(
                f"{_NOTICED:g} s after the connection broke the motion is still {state}: raise DeviceLost in its function"
            )
        with pytest.raises(NotReady):
            trial.move(device, home)
        _close(device)


def _close(device: Any) -> None:
    """Stop and close a device that is lost, which may say so again, and no more."""
    for end in (device.stop, device.close):
        begun = time.monotonic()
        try:
            end()
        except DeviceFault:
            pass
        except Exception as error:
            fault(f"{end.__name__}() after the loss raised {named(error)}; raise DeviceLost, or nothing")
        if (took := time.monotonic() - begun) > _CLOSING:
            fault(f"{end.__name__}() after the loss took {took:.1f} s, at most {_CLOSING:g} s allowed")
