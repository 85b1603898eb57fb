"""Texts of a tree: `$name` in them stands for the value of that name, in its unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stretch_bt.errors import NoAnswer
from stretch_bt.quantity_text import format_quantity
from stretch_bt.source import Scalar
from stretch_bt.tree.flow.base import Wire
from stretch_bt.tree.types import ANY, Family, Type
from stretch_bt.tree.values import NAMED

if TYPE_CHECKING:
    from stretch_bt.tree.build import Builder
    from stretch_bt.tree.reader import Reader

__all__ = ["Text", "read_text"]


@dataclass(slots=True)
class Text:
    """A text as the file has it, and the values that stand in it, in order."""

    written: str
    pieces: list[str | Wire] = field(default_factory=list)

    @property
    def wires(self) -> Sequence[Wire]:
        """The values in it."""
        return [piece for piece in self.pieces if isinstance(piece, Wire)]

    def bind(self, builder: Builder) -> Callable[[], str]:
        """Return what writes the text out with the values of that moment."""
        if not self.wires:
            return lambda: self.written
        said = [_said(piece, builder) for piece in self.pieces]
        return lambda: "".join(say() for say in said)


def read_text(reader: Reader, value: Scalar) -> Text:
    """Read a text; a name in it that means nothing is an error at its place."""
    found, end = Text(value.text), 0
    for match in NAMED.finditer(value.text):
        mark = value.mark.shifted(match.start() + value.quoted, len(match[0]))
        wire = reader.expression(Scalar(match[0], False, mark), ANY, "the text")
        if wire is not None:
            found.pieces += [value.text[end : match.start()], wire]
            end = match.end()
    found.pieces.append(value.text[end:])
    return found


def _said(piece: str | Wire, builder: Builder) -> Callable[[], str]:
    if isinstance(piece, str):
        return lambda: piece
    read, type_ = builder.thunk(piece), piece.expression.type if piece.expression else ANY

    def say() -> str:
        try:
            return _shown(read(), type_)
        except NoAnswer:
            return "none"

    return say


def _shown(value: Any, type_: Type) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(_shown(item, type_.item or ANY) for item in value)}]"
    if type_.is_number and type_.family is not Family.INT:
        return format_quantity(value, type_.dimension)
    return str(value)
