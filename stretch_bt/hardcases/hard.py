"""One hard case, and several that are hard for the same reason."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from stretch_bt.hardcases.expect import Expectation

__all__ = ["Hard", "Rows", "group"]


#: calls with their expected ends, by name
Rows = Mapping[str, tuple[Callable[[], Any], Expectation]]


@dataclass(frozen=True, slots=True)
class Hard:
    """An input that breaks numerics: why it does, the call, and the expected end of the call.

    `costly` marks a case that takes half a second of CPU or more and asks much the same as another one, or as a test; the
    suite runs it with the slow tests only.
    """

    name: str
    why: str
    call: Callable[[], Any]
    expect: Expectation
    costly: bool = False


def group(why: str, *rows: Rows, prefix: str = "", costly: tuple[str, ...] = ()) -> Iterator[Hard]:
    """Yield a case for each (call, expectation) by name; `costly` names those that are, without the prefix."""
    for some in rows:
        for name, (call, expect) in some.items():
            yield Hard(f"{prefix}{name}", why, call, expect, name in costly)
