"""A driver whose device one thread polls and commands: the base of a driver that has nothing else to say of its connection."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Generic, TypeVar

from stretch_bt.errors import DeviceFault, NotReady, shown
from stretch_bt.hardware.driver import Driver
from stretch_bt.hardware.wire_thread import Sample, Wire, WireThread

__all__ = ["PolledDriver"]

W = TypeVar("W", bound=Wire[Any])
S = TypeVar("S")
R = TypeVar("R")
_POLLS = 3.0


class PolledDriver(Driver, ABC, Generic[W, S]):
    """Derive a driver from this and from its kind, as in `class Mine(PolledDriver, GripperDriver)`; a loss of the wire stays."""

    streams: ClassVar[bool] = True
    #: rate of polls, Hz
    rate: float = 50.0
    #: the longest time that a command may take, and the device may be silent, s; three polls at least
    deadline: float = 1.0
    _thread: WireThread[W, S] | None = None
    #: what `wire` returned; a thread that hangs keeps it for itself
    _kept: W | None = None

    @abstractmethod
    def wire(self) -> W:
        """Return a new connection, not yet connected; asked for once, and connected anew at each `open`."""

    def open(self) -> None:
        """Connect and read once; moves nothing."""
        kept, self._kept = self._kept, None
        wire = self._connection() if kept is None else kept
        thread = WireThread[W, S](
            self.name,
            wire,
            period=1 / self.rate,
            deadline=max(self.deadline, _POLLS / self.rate),
            now=self.cell.now,
            at_loss=self.halt,
        )
        thread.start()
        self._thread, self._kept = thread, wire

    def _connection(self) -> W:
        found = self.wire()
        lacks = [name for name in ("connect", "read", "close") if not callable(getattr(found, name, None))]
        if lacks:
            what = f"{type(self).__name__}.wire() gave {shown(found)}, which has no {lacks[0]}()"
            raise DeviceFault(self.name, f"{what}; let it return a connection with connect(), read() and close()")
        return found

    def halt(self, wire: W) -> None:
        """Stop the device over its wire, also over one that gave no good answer and is about to be closed; nothing unless a driver says so."""

    def stop(self) -> None:
        """End any motion at once."""
        if type(self).halt is not PolledDriver.halt:
            self.do(self.halt)

    def close(self) -> None:
        """Disconnect; raises DeviceFault where a call on the connection does not return."""
        thread, self._thread = self._thread, None
        if thread is not None:
            wire, self._kept = self._kept, None
            thread.end()
            self._kept = wire

    def latest(self) -> Sample[S]:
        """Return the device's latest answer; raises DeviceLost after a loss, NotReady while it is closed."""
        return self._opened().latest()

    def do(self, job: Callable[[W], R]) -> R:
        """Run a job on the wire, before the next poll, and return what it returns; raises as `latest` does."""
        return self._opened().do(job)

    def command(self, job: Callable[[W], object]) -> int:
        """Run a job that begins a motion, and return a number for `since`."""
        before = self.latest

        def run(wire: W) -> int:
            job(wire)
            return before().number

        return self.do(run)

    def since(self, command: int) -> S | None:
        """Return the device's latest answer, None as long as that is from before a command; raises as `latest` does."""
        sample = self.latest()
        return sample.value if sample.number > command else None

    def _opened(self) -> WireThread[W, S]:
        if self._thread is None:
            raise NotReady(self.name, "the device is closed")
        return self._thread
