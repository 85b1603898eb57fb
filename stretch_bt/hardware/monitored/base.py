"""What is common to all devices: where they stand, faults that stay, readings with an age."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from stretch_bt.blame import place_of
from stretch_bt.clock import Clock
from stretch_bt.errors import (
    DeviceFault,
    DeviceLost,
    InvalidInput,
    LimitExceeded,
    NoAnswer,
    NotReady,
    StaleReading,
    StretchError,
    named,
)
from stretch_bt.hardware.asked import check_age
from stretch_bt.hardware.checked_reading import check_reading
from stretch_bt.hardware.claim import Claim
from stretch_bt.hardware.driver import Driver
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import DeviceState, Reading
from stretch_bt.hardware.journal import Relay
from stretch_bt.hardware.latched import NEW_RUN
from stretch_bt.hardware.limits import Limits

if TYPE_CHECKING:
    from stretch_bt.simulation.scene import Scene

__all__ = ["Monitored", "Watch"]

D = TypeVar("D", bound=Driver)
T = TypeVar("T")
_ROUNDING = 1e-9
#: how long to wait for a newer reading, s: while this thread computed, the one that takes readings may not have had its turn
_MOMENT, _PAUSE = 0.25, 0.002


@dataclass(frozen=True)
class Watch:
    """What watches over the devices of a cell.

    A tree that is run on them goes by `clock`, where there is one; `stamp` gives the tree's time for a time of `now`, where they differ.
    `scene` is the simulated scene.
    """

    now: Callable[[], float]
    limits: Limits
    hand: Hand
    journal: Relay
    clock: Clock | None = None
    stamp: Callable[[float], float] | None = None
    scene: Scene | None = None


class Monitored(Generic[D]):
    """A device around a driver.

    A fault of the device stays: commands are refused until it is closed and opened again, as by a new run. A stale reading or a
    command outside the limits is refused too, but leaves the device as it was.
    """

    def __init__(self, name: str, driver: D, watch: Watch) -> None:
        self.name = name
        self.driver = driver
        self.watch = watch
        self._state = DeviceState.DISCONNECTED
        self._fault: DeviceFault | None = None
        self._claim = Claim(name, driver.claimed())

    @property
    def state(self) -> DeviceState:
        """Where the device stands."""
        return self._state

    @property
    def fault(self) -> DeviceFault | None:
        """The fault that the device is in, or was in when it was closed; None if there is none."""
        return self._fault

    def open(self) -> None:
        """Connect, free of an earlier fault; moves nothing. Raises NotReady where another program has the device."""
        if self._state is not DeviceState.DISCONNECTED:
            return
        self._state, self._fault = DeviceState.CONNECTING, None
        with self.faults():
            try:
                self._claim.take()
                self.driver.open()
            except BaseException:
                self._state = DeviceState.DISCONNECTED
                with suppress(Exception):  # the half open device is closed; the error of opening is reported
                    self.driver.close()
                self._claim.release()
                raise
        self._state = DeviceState.READY

    def close(self) -> None:
        """Stop and disconnect; may be called in any state, more than once."""
        if self._state is DeviceState.DISCONNECTED:
            return
        try:
            self.stop()
        finally:
            self._state = DeviceState.DISCONNECTED
            try:
                with self.faults():
                    self.driver.close()
            finally:
                self._claim.release()

    def stop(self) -> None:
        """End any motion at once, whoever owns it."""
        if self._state is not DeviceState.DISCONNECTED:
            with self.faults():
                self.driver.stop()

    @contextmanager
    def faults(self) -> Iterator[None]:
        """Write down every fault and every NoAnswer that passes, turn other errors of a driver into faults, and keep the device's own.

        A refusal by a driver, because a place is out of reach or the device is not ready, leaves the device as it was.
        """
        try:
            yield
        except (StaleReading, LimitExceeded, NotReady) as fault:
            self.watch.journal.fault(self.name, fault)
            raise
        except DeviceFault as fault:
            if fault.device == self.name or not self.driver.simulated:
                self.latch(fault)
            else:  # of a device that a simulated one follows, which keeps it
                self.watch.journal.fault(self.name, fault)
            raise
        except NoAnswer as none:
            self.watch.journal.unanswered(self.name, none)
            raise
        except OSError as error:
            lost = DeviceLost(self.name, f"the connection broke ({error}); {NEW_RUN}")
            self.latch(lost)
            raise lost from error
        except StretchError as error:
            if not isinstance(error, InvalidInput) or self._state in (DeviceState.CONNECTING, DeviceState.DISCONNECTED):
                raise
            raise self._broke(error) from error  # numbers that its driver made, and that nothing can be
        except Exception as error:  # a defect of the driver, or an exception of its client that it does not know
            raise self._broke(error) from error

    def _broke(self, error: Exception) -> DeviceFault:
        at = place_of(error)
        broke = DeviceFault(
            self.name, f"its driver broke ({named(error)}){at and f' at {at}'}; mend it, then {NEW_RUN}"
        )
        self.latch(broke)
        return broke

    def latch(self, fault: DeviceFault) -> None:
        """Keep a fault until the device is opened again; the first one stays."""
        self.watch.journal.fault(self.name, fault)
        self.keep(fault)

    def keep(self, fault: DeviceFault) -> None:
        """Keep a fault that is written down where it was found."""
        self._fault = self._fault or fault
        if self._state is not DeviceState.DISCONNECTED:
            self._state = DeviceState.FAULT

    def refuse(self, fault: DeviceFault) -> DeviceFault:
        """Write down a fault that is not the device's own, and return it to be raised."""
        self.watch.journal.fault(self.name, fault)
        return fault

    def check_ready(self) -> None:
        """Raise NotReady unless the device takes commands."""
        if self._fault is not None:
            raise self.refuse(NotReady(self.name, f"in fault until a new run: {self._fault.reason}"))
        self.check_open()

    def check_open(self) -> None:
        """Raise NotReady while the device is closed."""
        if self._state is DeviceState.DISCONNECTED:
            raise self.refuse(NotReady(self.name, "the device is closed"))

    def command(self, name: str, arguments: Mapping[str, Any], owner: str) -> None:
        """Write down a command that is about to be sent."""
        self.watch.journal.command(self.name, name, arguments, owner)

    def fresh(self, name: str, source: Callable[[], Reading[T]], max_age: float) -> tuple[Reading[T], float]:
        """Return the latest reading and its age, s; of a device that streams one that is not too old, where it comes within a moment."""
        end = time.monotonic() + (_MOMENT if self.driver.streams else 0.0)
        while True:
            reading = self.checked(name, source())
            age = self.watch.now() - reading.host_time
            if age <= max_age or time.monotonic() >= end:
                return reading, age
            time.sleep(_PAUSE)

    def checked(self, name: str, reading: Reading[T]) -> Reading[T]:
        """Return a driver's reading; raises TypeError or ValueError for what is none."""
        check_reading(name, reading, self.watch.now())
        return reading

    def read(self, name: str, source: Callable[[], Reading[T]], max_age: float) -> Reading[T]:
        """Return a reading that is at most `max_age` s old."""
        check_age(self.name, max_age)
        self.check_open()
        with self.faults():
            reading, age = self.fresh(name, source, max_age + _ROUNDING)
            if age > max_age + _ROUNDING:
                raise StaleReading(self.name, f"the latest {name} is {age:.3g} s old, accepted are {max_age:.3g} s")
        if self.watch.stamp is not None:
            reading = replace(reading, host_time=self.watch.stamp(reading.host_time))
        self.watch.journal.reading(self.name, name, reading)
        return reading
