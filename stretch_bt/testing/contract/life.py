"""Clauses on constructing, opening and closing a device."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, ClassVar

import pytest

from stretch_bt.errors import DeviceFault, named
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.testing.contract.touches import touches
from stretch_bt.testing.contract.trial import Contract, Trial, fault, threads

__all__ = ["LifeClauses"]

#: how long threads of a driver may take to end after it is closed, and closing itself, s
_ENDING, _CLOSING = 2.0, 5.0


class LifeClauses:
    """Clauses for every device."""

    #: arguments that a test must have for the clauses of a class
    needs: ClassVar[tuple[str, ...]] = ()
    contract: ClassVar[Contract]
    trial: Trial

    @pytest.fixture(autouse=True)
    def _on_trial(self) -> Iterator[None]:
        with self.contract.trial() as self.trial:
            yield

    def test_constructing_touches_nothing(self) -> None:
        """A cell is read and shown on machines without the device: only `open` connects, nothing moves before."""
        self.trial.leave()  # the simulator is gone
        before = threads()
        with touches() as touched:
            try:
                driver = self.trial.driver()
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


def _no_thread_left(before: set[Any]) -> None:
    end = time.monotonic() + _ENDING
    while new := threads() - before:
        if time.monotonic() > end:
            fault(f"close() leaves the thread {new.pop().name!r} running; end it in close()")
        time.sleep(0.01)
