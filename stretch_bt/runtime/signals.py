"""Signals that ask for a safe stop: one handler, which passes each to whoever takes them at the moment."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any

__all__ = ["SIGNALS", "First", "came", "put_back", "signals", "unbroken"]

#: signals that ask for a safe stop; the last comes from a terminal that was closed
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))

#: names of the signals that came since the outermost block began, whoever took them
came: list[str] = []
#: who takes signals, the last one first
_receivers: list[Callable[[str], None]] = []
#: the signals that are taken, and whether each was blocked before
_taken: dict[int, bool] = {}


def _handle(number: int, _: Any) -> None:
    name = signal.Signals(number).name
    came.append(name)
    if _receivers:
        _receivers[-1](name)


@contextmanager
def signals(interrupt: Callable[[str], None]) -> Iterator[None]:
    """Pass the names of signals on while the block runs; only the main thread gets any.

    Within another such block the handler stays in its place, so no signal falls between the two. After the outermost
    block the handlers that were there before come back.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept: dict[int, Any] = {}
    if not _receivers:
        came.clear()
    _receivers.append(interrupt)
    try:
        for number in SIGNALS:
            before = signal.getsignal(number)
            if number in _taken or before is _handle or not _is_ours(number, before):
                continue
            kept[number] = before
            _taken[number] = _is_blocked(number)
        put_back()
        yield
    finally:
        try:
            for number, handler in reversed(kept.items()):  # SIGINT last, whose handler may raise at once
                _taken.pop(number, None)
                signal.signal(number, signal.SIG_DFL if handler is None else handler)
        finally:
            _receivers.pop()


def _is_ours(number: int, handler: Any) -> bool:
    """Whether a signal is to be taken: nohup asks to outlive the terminal, but a stop that is asked for is obeyed."""
    return handler is not signal.SIG_IGN or number in (signal.SIGINT, signal.SIGTERM)


def _is_blocked(number: int) -> bool:
    return number in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def put_back() -> list[str]:
    """Take the signals that are ours again where somebody set another handler or blocked them, and return their names.

    To be called in the main thread. One that came while it was blocked is heard at once.
    """
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    lost = [n for n, before in _taken.items() if signal.getsignal(n) is not _handle or (n in blocked and not before)]
    for number in lost:
        signal.signal(number, _handle)
    if lost:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [number for number in lost if not _taken[number]])
    return [signal.Signals(number).name for number in lost]


class First:
    """Lets the first signal break off what is going on, by whoever took signals before or with KeyboardInterrupt."""

    def __init__(self) -> None:
        self.breaks = True

    def __call__(self, name: str) -> None:
        """Take a signal."""
        if not self.breaks:
            return
        self.breaks = False
        for before in _receivers[: _receivers.index(self)][-1:]:
            before(name)
        raise KeyboardInterrupt(name)


@contextmanager
def unbroken() -> Iterator[list[BaseException]]:
    """Go through the block whatever signals come, then pass the first of them on; for code that stops devices, as the signals ask.

    The block is given a list for what breaks meanwhile: what the signal raises, if anything, has it as its notes.
    """
    errors: list[BaseException] = []
    if threading.current_thread() is not threading.main_thread():
        yield errors  # which hears none
        return
    before = len(came) if _receivers else 0
    with signals(lambda _: None):
        yield errors
    if len(came) == before:
        return
    try:
        _pass_on(came[before])
    except BaseException as stopped:
        for error in errors:
            stopped.add_note(str(error))
        raise


def _pass_on(name: str) -> None:
    if _receivers:
        _receivers[-1](name)
    else:  # to the handler that was there before
        signal.raise_signal(signal.Signals[name])
