"""A Ctrl-C between two calls on an open cell: what still moves is stopped before the interrupt goes on."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

__all__ = ["BetweenCalls"]

#: how long an interrupt waits for real devices to stop, s; they go on stopping after it
PATIENCE = 2.0
_OWN = __name__.partition(".")[0] + "."


class BetweenCalls:
    """Stops the devices at a SIGINT that comes while no call is ticked, then does what would have been done without it.

    Parameters
    ----------
    stop
        Stops every device.
    virtual
        Whether their time stands still meanwhile, so that a stop may wait until the next call.
    """

    def __init__(self, stop: Callable[[], None], *, virtual: bool) -> None:
        self._stop = stop
        self._virtual = virtual
        self._due = False
        self._calls = 0
        self._before: Any = None

    def begin(self) -> None:
        """Begin to listen; only the main thread hears signals."""
        if threading.current_thread() is threading.main_thread():
            self._before = signal.getsignal(signal.SIGINT)
            signal.signal(signal.SIGINT, self._handle)

    def end(self) -> None:
        """Put back the handler that was there before, unless somebody set another one since."""
        if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) == self._handle:
            signal.signal(signal.SIGINT, self._before or signal.default_int_handler)

    @contextmanager
    def calling(self) -> Iterator[None]:
        """Leave signals to the runner of a call, which stops more than the devices."""
        self._calls += 1
        try:
            yield
        finally:
            self._calls -= 1

    def settle(self) -> None:
        """Stop what an earlier signal could not stop at once."""
        if self._due:
            self._due = False
            self._stop()

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if not self._calls:
            self._stop_now(frame)
        if callable(self._before):
            self._before(number, frame)
        elif self._before is not signal.SIG_IGN:
            raise KeyboardInterrupt

    def _stop_now(self, frame: FrameType | None) -> None:
        if not self._virtual:
            # in a thread of its own: what was interrupted may hold a lock that a stop needs
            stopping = threading.Thread(target=self._stop, name="stop at SIGINT", daemon=True)
            stopping.start()
            stopping.join(PATIENCE)
        elif _within_package(frame):
            self._due = True  # a simulation is not changed in the middle of a step, and its time stands still
        else:
            with suppress(Exception):
                self._stop()


def _within_package(frame: FrameType | None) -> bool:
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        if name.startswith(_OWN) and name != __name__:
            return True
        frame = frame.f_back
    return False
