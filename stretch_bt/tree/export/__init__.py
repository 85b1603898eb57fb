"""Drawings of a checked task: an outline, Graphviz, SVG, a web page, and XML for BehaviorTree.CPP and Groot2."""

from __future__ import annotations

from importlib import import_module

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean
from stretch_bt.tree.program import Program

__all__ = ["FORMATS", "export"]

FORMATS = ("text", "dot", "svg", "html", "btcpp")


def export(program: Program, format: str = "text", *, wires: bool = False) -> str:  # noqa: A002
    """Return the task in one of `FORMATS`; a file of trees for import is shown tree by tree.

    As text, a wire that only repeats a name is shown short, unless `wires` are asked for; the other formats show all of them.

    Raises
    ------
    InvalidInput
        There is no such format.
    TreeError
        The task has errors.
    """
    if format not in FORMATS:
        raise InvalidInput(f"there is no format {format!r}; {did_you_mean(format, FORMATS)}")
    program.require()
    options = {"wires": wires} if format == "text" else {}
    written: str = import_module(f"{__name__}.{format}").write(program, **options)
    return written
