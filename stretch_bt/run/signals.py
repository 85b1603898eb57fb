"""Signals that ask for a safe stop."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["SIGNALS", "signals", "unbroken"]

#: what asks for a safe stop; the last is a terminal that was closed
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def signals(interrupt: Callable[[str], None]) -> Iterator[None]:
    """Pass the names of signals on while the block runs, then put the old handlers back; only the main thread gets any."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    kept: dict[int, Any] = {}
    try:
        for number in SIGNALS:
            before = signal.getsignal(number)
            if before is signal.SIG_IGN and number not in (signal.SIGINT, signal.SIGTERM):
                continue  # nohup
            kept[number] = before
            signal.signal(number, lambda n, _: interrupt(signal.Signals(n).name))
        yield
    finally:
        for number, handler in kept.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


@contextmanager
def unbroken() -> Iterator[None]:
    """Go through the block whatever signals come; for what stops devices, which is what they ask for."""
    with signals(lambda _: None):
        yield
