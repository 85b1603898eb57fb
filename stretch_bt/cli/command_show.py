"""`stretch-bt show`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean

__all__ = ["command"]


def command(
    tree: Annotated[str, typer.Argument(help="A tree file, or the name of a shipped tree.")],
    format_: Annotated[
        str | None,
        typer.Option(
            "--format", help="text, dot, svg, html or btcpp; by default the format of the ending of --out, else text"
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write to this file.")] = None,
    wires: Annotated[bool, typer.Option("--wires", help="As text, show every wire in full.")] = False,
) -> None:
    """Show a tree as text, as a picture, or as BehaviorTree.CPP XML."""
    from stretch_bt.tree.export import FORMATS, export, format_of
    from stretch_bt.tree.program import load_program

    if tree in FORMATS and not Path(tree).exists():
        raise InvalidInput(f"{tree!r} is a format, not a tree; write 'stretch-bt show TREE --format {tree}'")
    if format_ is not None and format_ not in FORMATS:
        raise InvalidInput(f"there is no format {format_!r}; {did_you_mean(format_, FORMATS)}")
    chosen = format_ or ("text" if out is None else format_of(out))
    if wires and chosen != "text":
        why = f"--wires belongs to the text form, not to {chosen}, which shows every wire in any case"
        raise InvalidInput(f"{why}; leave it out, or write --format text")
    text = export(load_program(tree).require(), chosen, wires=wires)
    if out is None:
        typer.echo(text)
    else:
        out.write_text(text, encoding="utf-8")
