"""`stretch-bt replay`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stretch_bt.cli.output import EXIT_FAILURE, emit_json

__all__ = ["command"]


def command(
    record: Annotated[Path, typer.Argument(help="The folder of a record.")],
    trust: Annotated[
        bool, typer.Option("--trust", help="Execute the Python modules that stand beside the recorded tree.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Tick a recorded tree again on its recorded readings, and report the first decision that differs."""
    from stretch_bt.run.replay import replay

    result = replay(record, trust=trust)
    if json_:
        emit_json(result.to_json())
    elif result.identical:
        typer.echo(f"identical: {result.decisions} decisions")
    else:
        first = result.first_difference or {}
        typer.echo(f"differs at tick {first.get('tick')}, {first.get('node')}")
        typer.echo(f"  recorded: {first.get('recorded')}")
        typer.echo(f"  replayed: {first.get('replayed')}")
    raise typer.Exit(0 if result.identical else EXIT_FAILURE)
