"""What the head of a task says, in words: devices, params, keys and outputs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from stretch_bt.tree.document import Declared, Document, Param
from stretch_bt.tree.schema.nodes import as_text, bounds_text

__all__ = ["HeadingRow", "documents", "facts", "rows"]


class HeadingRow(NamedTuple):
    """A declared name in words."""

    name: str
    type: str
    value: str
    bounds: str
    doc: str


def documents(document: Document) -> Iterable[Document]:
    """Yield a file and all that it imports."""
    yield document
    for imported in document.inner:
        yield from documents(imported)


def facts(document: Document) -> dict[str, str]:
    """Return scene, tick and devices of a task, each in one line."""
    devices = ", ".join(f"{d.name}: {d.interface.__name__}" for d in document.devices.values())
    found = {"scene": document.scene.text if document.scene else "", "tick": f"{document.tick_period * 1e3:g} ms"}
    return {name: text for name, text in {**found, "devices": devices}.items() if text}


def rows(declared: Iterable[Declared], prefix: str = "") -> list[HeadingRow]:
    """Return declarations in words; a param shows the value that a run takes."""
    return [_row(d, prefix) for d in declared]


def _row(declared: Declared, prefix: str) -> HeadingRow:
    has_value = declared.has_default or isinstance(declared, Param)
    value = declared.value if isinstance(declared, Param) else declared.default
    return HeadingRow(
        f"{prefix}{declared.name}",
        declared.type.name,
        as_text(value, declared.type) if has_value else "",
        bounds_text(declared.min, declared.max, declared.type),
        declared.doc,
    )
