"""A lock that is had in turn."""

from __future__ import annotations

import threading
from collections import deque

__all__ = ["Turns"]


class Turns:
    """A reentrant lock that threads get in the order in which they came.

    That of the standard library may be had again and again by a thread that just gave it back, while others wait.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: deque[tuple[int, threading.Lock]] = deque()
        self._owner: int | None = None
        self._depth = 0

    def __enter__(self) -> None:
        me, turn = threading.get_ident(), threading.Lock()
        with self._lock:
            if self._owner in (None, me):
                self._owner, self._depth = me, self._depth + 1
                return
            turn.acquire()
            self._waiting.append((me, turn))
        turn.acquire()  # whoever had it before hands it over

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._depth -= 1
            if self._depth:
                return
            self._owner = None
            if self._waiting:
                (self._owner, turn), self._depth = self._waiting.popleft(), 1
                turn.release()
