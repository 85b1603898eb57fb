"""Graphviz."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

from stretch_bt.tree.export.escape import dot
from stretch_bt.tree.export.style import fill, glyph
from stretch_bt.tree.export.view import NodeView, views
from stretch_bt.tree.program import Program

__all__ = ["write"]

_HEAD = """\
digraph "{name}" {{
  rankdir=LR; nodesep=0.12; ranksep=0.35; ordering=out;
  node [shape=box, style="filled,rounded", fontname="Helvetica", fontsize=11, margin="0.12,0.06", color="#8a94a3"];
  edge [arrowsize=0.6, color="#8a94a3"];
"""


def write(program: Program) -> str:
    """Return a directed graph, from left to right."""
    numbers = count()
    lines = [line for view in views(program) for line in _node(view, numbers, "")]
    return _HEAD.format(name=dot(program.document.file)) + "".join(f"  {line}\n" for line in lines) + "}\n"


def _node(view: NodeView, numbers: Iterator[int], parent: str, style: str = "") -> Iterator[str]:
    me = f"n{next(numbers)}"
    around = [text for text, _ in view.around]
    settings = [f"{name}: {value}" for name, value in view.settings.items()]
    label = "\\l".join(dot(line) for line in [*around, glyph(view), *settings]) + "\\l"
    yield f'{me} [label="{label}", tooltip="{dot(view.path)}", fillcolor="{fill(view.kind)}"];'
    if parent:
        yield f"{parent} -> {me}{style};"
    for child in view.children:
        yield from _node(child, numbers, me)
    if view.finish is not None:
        yield from _node(view.finish, numbers, me, ' [style=dashed, label="finally", fontsize=10]')
