"""How often a loop may run: a whole number, which may be none where an expression says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from stretch_bt.errors import NodeError
from stretch_bt.source import Scalar, Value
from stretch_bt.tree.flow.base import Wire
from stretch_bt.tree.types import INT

if TYPE_CHECKING:
    from stretch_bt.tree.reader import Reader

__all__ = ["counted", "read_count", "runs_surely"]

MOST = 1_000_000_000


def read_count(reader: Reader, value: Value, what: str) -> Wire | None:
    """Read a count; one that is written as a number is at least 1, because a loop that never runs is a slip."""
    is_number = not (isinstance(value, Scalar) and reader.is_expression(value, INT))
    return reader.value(value, INT, what, low=1 if is_number else 0, high=MOST)


def runs_surely(count: Wire) -> bool:
    """Whether there is at least one pass."""
    return bool(count.is_constant and count.value >= 1)


def counted(count: Callable[[], int], path: str, what: str) -> int:
    """Return how many passes there may be; raises NodeError where that is less than 0."""
    passes = count()
    if passes < 0:
        raise NodeError(path, f"{what} is {passes}; a loop runs 0 times or more")
    return passes
