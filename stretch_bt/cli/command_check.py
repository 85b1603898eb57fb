"""`stretch-bt check`."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from typing import Annotated

import typer

from stretch_bt.cli.output import EXIT_BAD_INPUT, emit_json, print_diagnostics

__all__ = ["command"]


def command(
    files: Annotated[
        list[str], typer.Argument(help="Tree, scene, cell, hand, mocks or sweep files, or names of shipped trees.")
    ],
    cell: Annotated[
        str | None, typer.Option(help="Cell file or shipped cell, against whose devices and limits the trees are held.")
    ] = None,
    fix: Annotated[
        bool, typer.Option("--fix", help="Rewrite tree files of the older form in place first, comments kept.")
    ] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Check files, all findings at once; opens no device."""
    from stretch_bt.runtime.check import check
    from stretch_bt.runtime.fix import fix_files

    with redirect_stdout(sys.stderr):  # what nodes print must not get among the findings
        left = fix_files(files) if fix else []
        said = {finding.file for finding in left if finding.severity == "error"}
        findings = [*left, *(f for f in check(files, cell=cell) if f.code != "retired" or f.file not in said)]
    errors = [f for f in findings if f.severity == "error"]
    if json_:
        emit_json([f.to_json() for f in findings])
    else:
        print_diagnostics(findings)
        warnings = len(findings) - len(errors)
        what = f"{_count(len(errors), 'error')}, {_count(warnings, 'warning')}" if findings else "no errors"
        typer.echo(f"{_count(len(files), 'file')}: {what}")
    raise typer.Exit(EXIT_BAD_INPUT if errors else 0)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
