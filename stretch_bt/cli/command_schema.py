"""`stretch-bt schema`."""

from __future__ import annotations

from typing import Annotated

import typer

from stretch_bt.cli.output import emit_json

__all__ = ["command"]


def command(
    kind: Annotated[str, typer.Argument(help="tree, scene, cell, mocks or sweep")],
    tree: Annotated[str | None, typer.Option(help="With the nodes that this tree file imports.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="The output is JSON with or without it.")] = False,
) -> None:
    """Print the JSON Schema of a kind of file, for editors; the nodes that are installed are in it."""
    from stretch_bt.cli.command_nodes import imported_nodes
    from stretch_bt.tree.schema import schema

    emit_json(schema(kind, {} if tree is None else imported_nodes(tree)))
