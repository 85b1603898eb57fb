"""Clauses on constructing, opening and closing a device."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import pytest

from stretch_bt.errors import DeviceFault, named
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.testing.contract.trial import Contract, Trial, distance, fault, shown, threads

__all__ = ["LifeClauses"]

#: how long threads of a driver may take to end after it is closed, and closing itself, s
_ENDING, _CLOSING = 2.0, 5.0
_TOUCHES = ("socket.connect", "subprocess.Popen", "open")


class LifeClauses:
    """Clauses for every device."""

    contract: ClassVar[Contract]
    trial: Trial

    @pytest.fixture(autouse=True)
    def _on_trial(self) -> Iterator[None]:
        with self.contract.trial() as self.trial:
            yield

    def test_constructing_touches_nothing(self) -> None:
        """A cell is read and shown on machines without the device: only `open` connects, nothing moves before."""
        with self.contract.simulator() as (_, spec):
            absent = Trial(self.contract, None, spec)
        before = threads()  # the simulator is gone
        with _touches() as touched:
            try:
                driver = absent.driver()
                driver.close()
            except Exception as error:
                fault(
                    f"constructing and closing the driver without its device raised {named(error)}; connect in open()"
                )
        if touched:
            fault(f"constructing the driver touches its device ({touched[0]}); connect in open()")
        if new := threads() - before:
            fault(f"constructing the driver starts the thread {new.pop().name!r}; start it in open()")

    def test_open_and_close_as_often_as_wanted(self) -> None:
        """A run opens and closes devices, the next run does so again: nothing may be left that keeps the device or its port."""
        before = threads()
        device = self.trial.open()
        for _ in range(2):
            for _ in range(2):
                begun = time.monotonic()
                device.close()
                if (took := time.monotonic() - begun) > _CLOSING:
                    fault(
                        f"closing took {took:.1f} s, at most {_CLOSING:g} s allowed: do not wait for a device that is silent"
                    )
                if device.state is not DeviceState.DISCONNECTED:
                    fault(f"after close() the device is {device.state}")
            _no_thread_left(before)
            device.stop()
            try:
                device.open()
            except DeviceFault as error:
                fault(f"it does not open a second time: {error.reason}; close() must let go of the connection")
            if device.state is not DeviceState.READY:
                fault(f"after open() the device is {device.state}")

    def test_opening_moves_nothing(self) -> None:
        """A person may have a hand in the cell when a run begins: opening reads, and the first motion is a command's."""
        if self.contract.moves is None:
            pytest.skip("no moves were named")
        trial = self.trial
        device = trial.open()
        trial.go(device, trial.moves[0])
        trial.wait(0.2 + self.contract.latency)
        before = trial.place(device)
        device.close()
        trial.wait(0.1)
        device.open()
        for passed in trial.ticks(0.5 + self.contract.latency):
            if (way := distance(trial.place(device), before)) > self.contract.tolerance:
                fault(
                    f"opening moves the device: it was closed at {shown(before)} and is {1e3 * way:.1f} mm from there {passed:.2f} s "
                    "after it was opened again; open() must not command a motion"
                )


def _no_thread_left(before: set[Any]) -> None:
    end = time.monotonic() + _ENDING
    while new := threads() - before:
        if time.monotonic() > end:
            fault(f"close() leaves the thread {new.pop().name!r} running; end it in close()")
        time.sleep(0.01)


class _Heard:
    """What the interpreter tells of while it listens; such a hook cannot be taken away again."""

    listening = False
    touched: ClassVar[list[str]] = []
    hooked = False

    @classmethod
    def hear(cls, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event that reaches out of the process."""
        if not cls.listening or event not in _TOUCHES:
            return
        what = str(arguments[1] if event == "socket.connect" else arguments[0])
        if event != "open" or what.startswith("/dev/tty"):
            cls.touched.append(f"{event} {what}")


@contextmanager
def _touches() -> Iterator[list[str]]:
    if not _Heard.hooked:
        sys.addaudithook(_Heard.hear)
        _Heard.hooked = True
    _Heard.touched.clear()
    _Heard.listening = True
    try:
        yield _Heard.touched
    finally:
        _Heard.listening = False
