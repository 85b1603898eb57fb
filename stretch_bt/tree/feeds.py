"""What feeds a port or a key in a run: constants, values that are worked out, values that may be absent, errors that go along."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stretch_bt.errors import Absent, NoAnswer, NodeError, StretchError, UnsetKey
from stretch_bt.tree.cell import MISSING, BoundedCell, Cell
from stretch_bt.tree.series import errors_of
from stretch_bt.tree.types import Type
from stretch_bt.tree.values import outside, within
from stretch_bt.units import Estimate

__all__ = [
    "BorrowedCell",
    "Computed",
    "Relay",
    "bounded",
    "bounds_check",
    "carried",
    "constant",
    "error_of_field",
    "present",
    "tee",
]


class Computed(Cell):
    """An input fed by an expression: worked out at each read."""

    __slots__ = ("error_of", "thunk")

    def __init__(self, name: str, thunk: Callable[[], Any], error_of: Callable[[], float | None] | None) -> None:
        super().__init__(name, value=None)
        self.thunk, self.error_of = thunk, error_of

    def read(self) -> Any:
        """Return the value of this moment."""
        return self.thunk()

    def error(self) -> float | None:
        """Return the standard deviation of this moment's value, or None where it has none."""
        return None if self.error_of is None else self.error_of()


def tee(target: Cell, target_sd: Cell) -> Cell:
    """Return an output whose standard deviation goes to a key of its own."""

    def pass_on(cell: Cell) -> None:
        if cell.value is MISSING:
            for key in (target, target_sd):
                key.unset(cell.writer)
            return
        target.write(cell.value if cell.sd is None else Estimate(cell.value, cell.sd), cell.writer)
        if cell.sd is None:
            raise NodeError(cell.writer, f"${target_sd.name} takes a standard deviation, and the node gave none")
        target_sd.write(cell.sd, cell.writer)

    made = Cell(target.name)
    made.listener = pass_on
    return made


class BorrowedCell(BoundedCell):
    """The key of a caller under the bounds of an `inout`: what lies outside them is neither read nor written."""

    __slots__ = ("outer",)

    def __init__(self, name: str, outer: Cell, check: Callable[[Any], None]) -> None:
        super().__init__(name, check)
        self.outer = outer
        self.listener = self._pass_on

    def begin(self) -> None:
        """Take over what the key holds."""
        self.value, self.sd, self.writer = self.outer.value, self.outer.error(), self.outer.writer

    def read(self) -> Any:
        """Return the value, if it lies within the bounds."""
        value = super().read()
        self.check(value)
        return value

    def _pass_on(self, _: Cell) -> None:
        _hand_on(self, self.outer)


class Relay:
    """Passes on what is written to a cell: of an output of a called tree, or of a node to a key with bounds.

    A called tree reads nothing of what the key of its caller held before. A default is there from the begin of a call on,
    and reaches the key of the caller where the call succeeds and wrote nothing else.
    """

    def __init__(self, inner: Cell, outer: Cell, default: Any = MISSING) -> None:
        self.inner, self.outer, self.default = inner, outer, default
        self.passed = False
        inner.listener = self._pass_on

    def begin(self) -> None:
        """Go back to the default."""
        self.passed = False
        self.inner.reset(self.default)

    def succeed(self, path: str) -> None:
        """Give the key the default, if nothing was written to it."""
        if not (self.passed or self.default is MISSING):
            self.outer.give(self.default, path)

    def _pass_on(self, cell: Cell) -> None:
        self.passed = True
        _hand_on(cell, self.outer)


def _hand_on(cell: Cell, outer: Cell) -> None:
    if cell.value is MISSING:
        outer.unset(cell.writer)
    else:
        outer.write(cell.held(), cell.writer)


def constant(name: str, value: Any, writer: str) -> Cell:
    """Return a cell that keeps a value; None is absence."""
    cell = Cell(name, MISSING if value is None else value)
    cell.writer = writer
    return cell


def present(
    thunk: Callable[[], Any], default: Any, kinds: tuple[type[StretchError], ...] = (UnsetKey, Absent)
) -> Callable[[], Any]:
    """Return what gives the default of a port, or None, where a key holds nothing."""
    absent = None if default is MISSING else default

    def read() -> Any:
        try:
            return thunk()
        except kinds:
            return absent

    return read


def carried(error: Callable[[], float | None], default: Any, name: str) -> Callable[[], Any]:
    """Return a function that gives the error of a value, and the default of the port where there is none."""

    def read() -> Any:
        sd = error()
        if sd is None and default is MISSING:
            raise UnsetKey(
                f"{name} is not given, and the value of {name.removesuffix('_sd')} has no standard deviation"
            )
        return default if sd is None else sd

    return read


def error_of_field(cell: Cell, parts: tuple[str, ...]) -> float | None:
    """Return the field `x_sd` that stands beside a field `x` of a record, or the error of an item of a list."""
    try:
        value, last = cell.read(), parts[-1]
    except (UnsetKey, Absent):
        return None
    for part in parts[:-1]:
        value = _part(value, part)
    if last.isdigit():
        value = errors_of(value) if isinstance(value, list | tuple) else None
    found = _part(value, last if last.isdigit() else f"{last}_sd")
    return found if isinstance(found, float) else None


def _part(value: Any, name: str) -> Any:
    """Return an item of a list, or an attribute; None where there is no such."""
    if not name.isdigit():
        return getattr(value, name, None)
    return value[int(name)] if isinstance(value, list | tuple) and int(name) < len(value) else None


def bounded(thunk: Callable[[], Any], check: Callable[[Any], None]) -> Callable[[], Any]:
    """Hold a value that is not known at load against bounds; its reader fails where it is outside."""

    def read() -> Any:
        value = thunk()
        check(value)
        return value

    return read


def bounds_check(name: str, type_: Type, low: float | None, high: float | None) -> Callable[[Any], None]:
    """Return what raises NoAnswer for a number, or an item of a list, outside the bounds of a port or of a declared name."""

    def check(value: Any) -> None:
        for number in value if isinstance(value, list | tuple) else (value,):
            if number is not None and not within(number, low, high):
                raise NoAnswer(f"{name}: {outside(number, type_.item or type_, low, high)}")

    return check
