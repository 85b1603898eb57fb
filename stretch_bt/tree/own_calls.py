"""Which functions of this package call the code of a node: only there may that code be cut off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple, TypeVar

__all__ = ["OwnCall", "calls_own", "find_own_call", "ticks_own"]

_PACKAGE = str(Path(__file__).resolve().parent.parent) + "/"
#: code of the functions that call a node, and of the functions that begin a tick or an end of one
_callers: set[CodeType] = set()
_ticks: set[CodeType] = set()

F = TypeVar("F", bound=Callable[..., Any])


class OwnCall(NamedTuple):
    """A call of a node that is going on: its frame, its node, and whether the node's own code is at work."""

    frame: FrameType
    node: Any
    own: bool


def calls_own(function: F) -> F:
    """Mark a function that calls code of a node while it holds nothing that must be put in order."""
    _callers.add(function.__code__)
    return function


def ticks_own(method: F) -> F:
    """Mark a method of a node, too, that is one whole call of it: a tick, or its end."""
    _ticks.add(method.__code__)
    return calls_own(method)


def find_own_call(frame: FrameType | None) -> OwnCall | None:
    """Return the innermost call of a node on the stack; its own code is at work where no other code of ours is above it."""
    innermost = frame
    own: bool | None = None
    while frame is not None:
        code = frame.f_code
        if own is None and code.co_filename.startswith(_PACKAGE):
            own = code in _callers and frame is not innermost
        if code in _ticks:
            return OwnCall(frame, frame.f_locals["self"], bool(own))
        frame = frame.f_back
    return None
