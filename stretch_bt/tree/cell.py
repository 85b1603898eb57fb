"""Where the value of a key lives during a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stretch_bt.errors import Absent, UnsetKey
from stretch_bt.units import Estimate

__all__ = ["MISSING", "BoundedCell", "Cell"]


class _Missing:
    """The absence of a value, where None is one."""

    def __repr__(self) -> str:
        return "unset"

    def __bool__(self) -> bool:
        return False


MISSING: Any = _Missing()


#: the writer of a key that is absent by its default
_DEFAULT = "default"


class Cell:
    """Where a key's value lives during a run, with its standard deviation."""

    __slots__ = ("blocked", "listener", "name", "sd", "value", "writer", "writes")

    def __init__(self, name: str, value: Any = MISSING) -> None:
        self.name = name
        self.value = value
        self.sd: float | None = None
        self.writer = ""
        self.writes = 0  # how often it was written, or left without a value by a node
        self.blocked = ""  # why nothing may ever write it
        self.listener: Callable[[Cell], None] | None = None

    def read(self) -> Any:
        """Return the value; raises UnsetKey when nothing wrote it yet, and Absent when what wrote it had none."""
        if self.value is MISSING:
            if self.writer == _DEFAULT:
                raise Absent(f"${self.name} is none, as it is by default")
            if self.writer:
                raise Absent(f"${self.name} is none: {self.writer} had no value for it")
            raise UnsetKey(f"${self.name} is read before anything wrote it{self.blocked and '; ' + self.blocked}")
        return self.value

    def held(self) -> Any:
        """Return what it holds: a number with a standard deviation as an Estimate, None where it holds nothing."""
        if self.value is MISSING:
            return None
        return self.value if self.sd is None else Estimate(self.value, self.sd)

    def error(self) -> float | None:
        """Return the standard deviation of the value, or None where it has none."""
        return self.sd

    def read_sd(self) -> float:
        """Return the standard deviation of the value; raises UnsetKey when it has none."""
        sd = self.error()
        if self.value is MISSING or sd is None:
            raise UnsetKey(f"${self.name} has no standard deviation")
        return sd

    def reset(self, value: Any = MISSING) -> None:
        """Go back to a default, of which None is absence, or to unset."""
        absent = value is None
        self.value = MISSING if absent else value
        self.sd = None
        self.writer = _DEFAULT if absent else ""

    def write(self, value: Any, writer: str = "") -> None:
        """Set the value, and its standard deviation when the value is an Estimate; `writer` is the path of a node."""
        if type(value) is Estimate:
            self.sd = value.sd
            value = float(value)
        else:
            self.sd = None
        self.value = value
        self.writer = writer
        self.writes += 1
        if self.listener is not None:
            self.listener(self)

    def give(self, default: Any, writer: str) -> None:
        """Write a default, of which None is absence."""
        if default is None:
            self.unset(writer)
        else:
            self.write(default, writer)

    def unset(self, writer: str = "") -> None:
        """Leave the key without a value, as a node does that writes None to an output that may be absent."""
        self.value, self.sd, self.writer = MISSING, None, writer
        self.writes += 1
        if self.listener is not None:
            self.listener(self)


class BoundedCell(Cell):
    """The cell of a name that is declared with bounds: `check` raises NoAnswer for a value outside them, which is not written."""

    __slots__ = ("check",)

    def __init__(self, name: str, check: Callable[[Any], None]) -> None:
        super().__init__(name)
        self.check = check

    def write(self, value: Any, writer: str = "") -> None:
        """Set the value, if it lies within the bounds."""
        self.check(value)
        super().write(value, writer)
