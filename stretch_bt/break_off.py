"""Breaking off a solve that nobody waits for any more."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["BrokenOff", "breakable", "go_on"]


class BrokenOff(BaseException):
    """A solve was broken off; it is no NoAnswer, after which solvers and nodes would try another way."""


def _never() -> bool:
    return False


_asked: ContextVar[Callable[[], bool]] = ContextVar("asked", default=_never)


@contextmanager
def breakable(asked: Callable[[], bool]) -> Iterator[None]:
    """Let solves of this thread within the block be broken off as soon as they are `asked` to."""
    token = _asked.set(asked)
    try:
        yield
    finally:
        _asked.reset(token)


def go_on() -> None:
    """Raise BrokenOff where the solve is to be broken off; solvers call it where their kept state is whole."""
    if _asked.get()():
        raise BrokenOff
