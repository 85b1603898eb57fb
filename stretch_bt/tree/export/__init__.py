"""Drawings of a checked task: an outline, Graphviz, SVG, a web page, and XML for BehaviorTree.CPP and Groot2."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean
from stretch_bt.tree.program import Program

__all__ = ["FORMATS", "export", "format_of"]

FORMATS = ("text", "dot", "svg", "html", "btcpp")
#: by the ending of a file: its format
_ENDINGS = {
    ".txt": "text",
    ".dot": "dot",
    ".gv": "dot",
    ".svg": "svg",
    ".html": "html",
    ".htm": "html",
    ".xml": "btcpp",
}


def format_of(path: Path) -> str:
    """Return the format that the ending of a file stands for; a name without one, as /dev/stdout, takes text.

    Raises
    ------
    InvalidInput
        The ending stands for none.
    """
    ending = path.suffix.lower()
    if not ending:
        return "text"
    if ending not in _ENDINGS:
        *most, last = _ENDINGS
        raise InvalidInput(
            f"{path.name!r} does not end in {', '.join(most)} or {last}; write a name such as {path.stem}.svg, or name "
            f"its format with --format {', '.join(FORMATS[:-1])} or {FORMATS[-1]}"
        )
    return _ENDINGS[ending]


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
