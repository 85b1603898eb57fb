"""`stretch-bt new`."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Annotated

import typer

from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean

__all__ = ["command"]

KINDS = {"tree": ".yaml", "scene": ".yaml", "node": ".py"}


def command(
    kind: Annotated[str, typer.Argument(help="tree, node or scene")],
    name: Annotated[str, typer.Argument(help="Its name, and that of the file.")],
) -> None:
    """Write a commented file to begin with, in the present folder."""
    if kind not in KINDS:
        raise InvalidInput(f"{kind!r} is not a kind of file; {did_you_mean(kind, KINDS)}")
    if not name.isidentifier() or not name.islower():
        raise InvalidInput(f"{name!r} is not a name; use small letters, digits and _")
    path = Path(f"{name}{KINDS[kind]}")
    template = files("stretch_bt.cli").joinpath("templates", f"{kind}{KINDS[kind]}.txt").read_text("utf-8")
    title = "".join(part.capitalize() for part in name.split("_"))
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(template.replace("NAME", name).replace("TITLE", title))
    except FileExistsError:
        raise InvalidInput(f"{path} is there already; choose another name") from None
    typer.echo(str(path))
