"""An outline for a terminal: the tree on the left, the path of each node on the right."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from stretch_bt.tree.export.escape import clean
from stretch_bt.tree.export.headings import HeadingRow, documents, facts, rows
from stretch_bt.tree.export.view import NodeView, views
from stretch_bt.tree.program import Program

__all__ = ["write"]

WIDTH = 84
NARROW = 24  # text keeps this much room, however deep it stands

Line = tuple[str, str]


def write(program: Program, *, wires: bool = False) -> str:
    """Return the outline; a wire that only repeats a name is shown as that name alone, unless `wires` are asked for."""
    document = program.document
    head = [document.file, *textwrap.wrap(document.doc, WIDTH, initial_indent="  ", subsequent_indent="  "), ""]
    head += [f"{name:<9}{text}" for name, text in facts(document).items()]
    params = [row for d in documents(document) for row in rows(d.params.values(), d.prefix)]
    head += _table("params", params)
    if "main" in document.trees:
        head += _table("out", rows(document.trees["main"].outs.values()))
    body = [line for view in views(program) for line in ("", *_columns(list(_root(view, wires))))]
    return clean("\n".join([*head, *body]) + "\n")


def _table(title: str, given: Sequence[HeadingRow]) -> Iterator[str]:
    widths = [max((len(row[i]) for row in given), default=0) for i in range(4)]
    for i, row in enumerate(given):
        cells = "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=False) if width)
        yield f"{title if i == 0 else '':<9}{cells}  {row.doc}".rstrip()


def _columns(lines: list[Line]) -> Iterator[str]:
    width = max(len(left) for left, path in lines if path)
    for left, path in lines:
        yield f"{left:<{width}}  {path}".rstrip()


def _root(view: NodeView, wires: bool) -> Iterator[Line]:
    settings = ", ".join(_settings(view, wires))
    yield from _wrapped(f"{view.title}:" + (f"  {settings}" if settings else ""), "", "│ ", view.path)
    yield from _below(view, "", wires)


def _below(view: NodeView, prefix: str, wires: bool) -> Iterator[Line]:
    inside = [(child, "") for child in view.children]
    if view.finish is not None:
        inside.append((view.finish, "finally: "))
    for i, (child, word) in enumerate(inside):
        last = i == len(inside) - 1
        yield from _node(child, prefix + ("└─ " if last else "├─ "), prefix + ("   " if last else "│  "), word, wires)


def _node(view: NodeView, first: str, rest: str, word: str, wires: bool) -> Iterator[Line]:
    for text, path in view.around:
        yield from _wrapped(text, first, rest, path)
        first = rest
    called = f" ({view.keyword})" if view.keyword != view.title and not view.keyword.endswith(f".{view.title}") else ""
    settings = ", ".join(_settings(view, wires))
    text = f"{word}{view.title}{called}" + (f"  {settings}" if settings else "")
    below = "│  " if view.children or view.finish else "   "
    yield from _wrapped(text, first, rest + below, view.path)
    yield from _below(view, rest, wires)


def _settings(view: NodeView, wires: bool) -> Iterator[str]:
    for name, value in view.settings.items():
        if wires or (name not in view.left_out and value != f"${name}"):
            yield f"{name}: {value}"
        elif name not in view.left_out:
            yield name


def _wrapped(text: str, first: str, rest: str, path: str) -> Iterator[Line]:
    """Yield text within the width; the path stands beside its first line."""
    room = max(WIDTH, len(rest) + NARROW)
    lines = textwrap.wrap(text, room, initial_indent=first, subsequent_indent=rest + "  ", break_on_hyphens=False)
    for i, line in enumerate(lines):
        yield line, path if i == 0 else ""
