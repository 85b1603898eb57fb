"""Signals that ask for a safe stop: one handler, which passes each to whoever takes them at the moment."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager

TYPE_CHECKING = False  # see stretch_bt/__init__.py
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any

__all__ = ["SIGNALS", "First", "signals", "unbroken"]

#: what asks for a safe stop; the last is a terminal that was closed
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))

#: who takes signals, the last one first
_receivers: list[Callable[[str], None]] = []


def _handle(number: int, _: Any) -> None:
    if _receivers:
        _receivers[-1](signal.Signals(number).name)


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
    _receivers.append(interrupt)
    try:
        for number in SIGNALS:
            before = signal.getsignal(number)
            if before is _handle or (before is signal.SIG_IGN and number not in (signal.SIGINT, signal.SIGTERM)):
                continue  # it stands; or nohup asks to outlive the terminal, though a stop that is asked for is obeyed
            kept[number] = before
            signal.signal(number, _handle)
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        _receivers.pop()


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
def unbroken() -> Iterator[None]:
    """Go through the block whatever signals come; for what stops devices, which is what they ask for."""
    with signals(lambda _: None):
        yield
