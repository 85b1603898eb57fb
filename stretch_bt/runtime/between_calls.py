"""A signal between two calls on an open cell: any device that still moves is stopped before the signal goes on to whoever had it before."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, Protocol

from stretch_bt.runtime.signals import SIGNALS

__all__ = ["BetweenCalls"]

#: how long a signal waits for real devices to stop, s; they go on stopping after it
PATIENCE = 2.0
_OWN = __name__.partition(".")[0] + "."


class Interruptible(Protocol):
    """A runner."""

    def interrupt(self, why: str) -> None:
        """Ask for a safe stop."""
        ...


class BetweenCalls:
    """Stops the devices of an open cell at a signal that comes while no call of the main thread is ticked.

    Parameters
    ----------
    stop
        Stops every device.
    virtual
        Whether their time stands still meanwhile, so that a stop may wait until the next call.
    """

    def __init__(self, stop: Callable[[], object], *, virtual: bool) -> None:
        self._stop = stop
        self._virtual = virtual
        self._due = False
        self._runners: list[Interruptible] = []

    def listen(self) -> None:
        """Listen from now on, also where somebody else took the handlers meanwhile, as a notebook does for each of its cells."""
        if self not in _listening:
            _listening.append(self)
        _take()

    def end(self) -> None:
        """Listen no more."""
        if self in _listening:
            _listening.remove(self)
        if not _listening:
            _give_back()

    @contextmanager
    def calling(self, runner: Interruptible) -> Iterator[None]:
        """Leave signals to the runner of a call; in another thread than the main one it is asked to stop by this."""
        self._runners.append(runner)
        try:
            yield
        finally:
            self._runners.remove(runner)

    def settle(self) -> None:
        """Stop what an earlier signal could not stop at once."""
        if self._due:
            self._due = False
            self._stop()

    def hear(self, name: str, frame: FrameType | None) -> None:
        """Stop what moves, because of a signal."""
        for runner in self._runners:
            runner.interrupt(name)
        if self._runners:
            return
        if not self._virtual:
            # in a thread of its own: the interrupted code may hold a lock that a stop needs
            stopping = threading.Thread(target=self._stop, name=f"stop at {name}", daemon=True)
            stopping.start()
            stopping.join(PATIENCE)
        elif _within_package(frame):
            self._due = True  # a simulation is not changed in the middle of a step, and its time stands still
        else:
            with suppress(Exception):
                self._stop()


#: the open cells of the process, and the handlers that were there before
_listening: list[BetweenCalls] = []
_before: dict[int, Any] = {}


def _take() -> None:
    if threading.current_thread() is not threading.main_thread():
        return
    for number in SIGNALS:
        present = signal.getsignal(number)
        ignored = present is signal.SIG_IGN and number == getattr(
            signal, "SIGHUP", None
        )  # it is to outlive its terminal
        own = getattr(present, "__module__", "").startswith(_OWN)  # a run has it at the moment
        if present is not _handle and not ignored and not own:
            _before[number] = present
            signal.signal(number, _handle)


def _give_back() -> None:
    if threading.current_thread() is threading.main_thread():
        for number, handler in list(_before.items()):
            if signal.getsignal(number) is _handle:
                signal.signal(number, signal.SIG_DFL if handler is None else handler)
                del _before[number]


def _handle(number: int, frame: FrameType | None) -> None:
    for cell in list(_listening):
        cell.hear(signal.Signals(number).name, frame)
    before = _before.get(number)
    if callable(before):
        before(number, frame)
    elif before is not signal.SIG_IGN:
        raise SystemExit(128 + number)  # so that `with` and what runs at exit close the cell


def _within_package(frame: FrameType | None) -> bool:
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        if name.startswith(_OWN) and name != __name__:
            return True
        frame = frame.f_back
    return False
