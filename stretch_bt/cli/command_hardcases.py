"""`stretch-bt hardcases`."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import EXIT_FAILURE, emit_json, in_place

if TYPE_CHECKING:
    from stretch_bt.hardcases import CaseRow

__all__ = ["command"]


def command(
    domain: Annotated[list[str] | None, typer.Option(help="A domain, such as membrane; all when left out.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
) -> None:
    """Run the inputs that break numerics, and say which do not end as they must."""
    from stretch_bt.hardcases import DOMAINS, cases, run

    chosen = {name: cases(name) for name in dict.fromkeys(domain or DOMAINS)}
    rows: list[CaseRow] = []
    with redirect_stdout(sys.stderr):  # what a case prints must not get among the result
        for name, found in chosen.items():
            for hard in found.values():
                in_place(f"{name}: {hard.name}")
                rows.append(run(name, hard))
        in_place("")
    if json_:
        emit_json([row.to_json() for row in rows])
    else:
        _show(rows)
    if not all(row.ok for row in rows):
        raise typer.Exit(EXIT_FAILURE)


def _show(rows: list[CaseRow]) -> None:
    for row in rows:
        mark, color = ("ok", typer.colors.GREEN) if row.ok else ("no", typer.colors.RED)
        typer.secho(f"{mark}  {row.domain}: {row.name}: {row.expected}", fg=color)
        if not row.ok:
            typer.echo(f"    {row.outcome}")
    wrong = sum(not row.ok for row in rows)
    ended = "all end as they must" if not wrong else f"{wrong} do not end as they must"
    typer.echo(f"{len(rows)} cases, {ended}, {sum(row.seconds for row in rows):.1f} s of CPU")
