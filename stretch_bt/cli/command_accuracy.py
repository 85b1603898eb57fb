"""`stretch-bt accuracy`."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import emit_json

if TYPE_CHECKING:
    from stretch_bt.accuracy import Row

__all__ = ["command"]


def command(
    names: Annotated[list[str] | None, typer.Argument(help="Domains, such as membrane; all when left out.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A small subset, in seconds.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the rows and a picture into this new folder.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
) -> None:
    """Measure error against CPU time, with the error of the reference stated."""
    from stretch_bt.accuracy import domains, measure
    from stretch_bt.accuracy.folder import write
    from stretch_bt.accuracy.table import table
    from stretch_bt.runtime.record.folder import claim

    chosen = domains(names or [])
    folder = None if out is None else claim(out)
    rows: list[Row] = []
    try:
        with redirect_stdout(sys.stderr):  # what other simulators print must not get among the result
            for row in measure(chosen, quick=quick):
                rows.append(row)
                _progress(row.case)
        _progress("")
    finally:
        if folder is not None:
            write(folder, rows)
    if json_:
        emit_json([row.to_json() for row in rows])
        return
    for name, domain in chosen.items():
        typer.echo(table(name, domain.ABOUT, domain.KINDS, [row for row in rows if row.domain == name]))


def _progress(case: str) -> None:
    """Show on a terminal what has just been measured, in place of what was before it."""
    if sys.stderr.isatty():
        typer.echo(f"\r\033[K{case[:70]}", nl=False, err=True)
