"""Cutting off the code of a node that does not return although a signal asks the run to stop."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

from stretch_bt.tree.own_calls import find_own_call

__all__ = ["PATIENCE", "CutOff", "Patience"]

#: how long the code of a node may go on after a signal, s
PATIENCE = 1.0
#: when to look again at a node that was met inside a function of this package, s
_SOON = 0.02
#: after so many cuts that a node swallowed the next one comes while it still handles the last, where it catches nothing
_POLITE, _AT_ONCE = 3, 50e-6


class CutOff(BaseException):
    """The code of a node was cut off. It is no Exception, so that a node which catches every Exception ends all the same."""

    def __init__(self, path: str) -> None:
        super().__init__(f"{path}: its code did not return within {PATIENCE:g} s after a signal, and was cut off")
        self.path = path


class Patience:
    """Gives each call of a node a time to return in, from a signal on; a block in which the alarm of the process is borrowed.

    The alarm interrupts waits as a signal does, and a handler may raise where it comes. That is done only where the own code of a
    node is at work: drivers, the record and the runner never leave their work half done. Outside the main thread, which alone
    gets signals, nothing is done.

    Parameters
    ----------
    hurried
        Says whether the run waits for the node, so that it may be cut off.
    path_of
        Gives the path of a node.
    """

    def __init__(self, hurried: Callable[[], bool], path_of: Callable[[Any], str]) -> None:
        self._hurried = hurried
        self._path_of = path_of
        self._within = False
        self._call: FrameType | None = None
        self._cuts = 0
        self._borrowed: _Alarm | None = None

    def __enter__(self) -> None:
        self._within = threading.current_thread() is threading.main_thread()

    def __exit__(self, *_: object) -> None:
        self._within, self._call = False, None
        if self._borrowed is not None:
            self._borrowed.give_back()
            self._borrowed = None

    def begin(self) -> None:
        """Begin to wait for the call that is going on, and then for those after it, as long as the run is hurried."""
        if not self._within or threading.current_thread() is not threading.main_thread():
            return
        if self._borrowed is None:
            self._borrowed = _Alarm(self._alarm)
        found = find_own_call(sys._getframe())
        self._wait_for(None if found is None else found.frame)

    def _wait_for(self, call: FrameType | None) -> None:
        self._call, self._cuts = call, 0
        signal.setitimer(signal.ITIMER_REAL, PATIENCE)

    def _alarm(self, _: int, frame: FrameType | None) -> None:
        """Cut off the call that was waited for; wait for another one that came since."""
        if not self._within or not self._hurried():
            return
        found = find_own_call(frame)
        if found is None or found.frame is not self._call:
            self._wait_for(None if found is None else found.frame)
        elif not found.own:
            signal.setitimer(signal.ITIMER_REAL, _SOON)
        else:
            self._cuts += 1
            signal.setitimer(signal.ITIMER_REAL, PATIENCE if self._cuts < _POLITE else _AT_ONCE)
            raise CutOff(self._path_of(found.node))


class _Alarm:
    """The alarm of the process, borrowed from whoever had it."""

    def __init__(self, handler: Callable[[int, FrameType | None], None]) -> None:
        self.since = time.monotonic()
        self.timer = signal.getitimer(signal.ITIMER_REAL)
        self.handler = signal.getsignal(signal.SIGALRM)
        signal.signal(signal.SIGALRM, handler)
        self.blocked = signal.SIGALRM in signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGALRM])

    def give_back(self) -> None:
        """Put handler and timer back; an alarm that was due meanwhile comes now."""
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL if self.handler is None else self.handler)
        if self.blocked:
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM])
        rest, interval = self.timer
        if rest:
            signal.setitimer(signal.ITIMER_REAL, max(rest - (time.monotonic() - self.since), 1e-6), interval)
