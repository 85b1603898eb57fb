"""`stretch-bt replay`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import EXIT_FAILURE, AsJson, emit_json, warn

if TYPE_CHECKING:
    from stretch_bt.runtime.replay import ReplayResult

__all__ = ["command"]


def command(
    record: Annotated[Path, typer.Argument(help="The folder of a record.")],
    trust: Annotated[
        bool, typer.Option("--trust", help="Execute the Python modules that stand beside the recorded tree.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """Tick a recorded tree again on its recorded readings, and report the first decision that differs."""
    from stretch_bt.runtime.replay import replay

    result = replay(record, trust=trust, say=_say_executed)
    for other in result.others:
        warn(f"the replay ran another {other}")
    if result.damage is not None:
        warn(result.damage)
    if json_:
        emit_json(result.to_json())
    else:
        _show(result)
    raise typer.Exit(0 if result.same else EXIT_FAILURE)


def _say_executed(file: str) -> None:
    typer.echo(f"executing {file}", err=True)


def _show(result: ReplayResult) -> None:
    first = result.first_difference or {}
    place = f"tick {first.get('tick')}, {first.get('node')}"
    until = "" if result.until is None else f", up to {result.until:g} s, where the record ends"
    if result.identical:
        typer.echo(f"identical: {result.decisions} decisions{until}")
    elif result.same:
        largest = result.largest_difference
        typer.echo(
            f"same: {result.decisions} decisions{until}; numbers differ by {largest:.1g} at most, first at {place}"
        )
    else:
        typer.echo(f"differs at {place}")
        typer.echo(f"  recorded: {first.get('recorded')}")
        typer.echo(f"  replayed: {first.get('replayed')}")
