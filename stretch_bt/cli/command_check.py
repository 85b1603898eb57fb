"""`stretch-bt check`."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import EXIT_BAD_INPUT, emit_json, print_diagnostics

if TYPE_CHECKING:
    from stretch_bt.errors import Diagnostic

__all__ = ["command"]


def command(
    files: Annotated[
        list[str], typer.Argument(help="Tree, scene, cell, hand or mocks files, or names of shipped trees.")
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
    from stretch_bt.run.check import check

    with redirect_stdout(sys.stderr):  # what nodes print must not get among the findings
        left = _fixed(files) if fix else []
        findings = [*left, *(f for f in check(files, cell=cell) if f.code != "retired" or not left)]
    errors = [f for f in findings if f.severity == "error"]
    if json_:
        emit_json([f.to_json() for f in findings])
    else:
        print_diagnostics(findings)
        warnings = len(findings) - len(errors)
        what = f"{_count(len(errors), 'error')}, {_count(warnings, 'warning')}" if findings else "no errors"
        typer.echo(f"{_count(len(files), 'file')}: {what}")
    raise typer.Exit(EXIT_BAD_INPUT if errors else 0)


def _fixed(files: list[str]) -> list[Diagnostic]:
    """Rewrite the tree files among those that are named, and return what is left to their author."""
    from stretch_bt.run.fix import fix_tree

    paths = [path for path in map(Path, files) if path.suffix in (".yaml", ".yml") and path.is_file()]
    return [found for path in paths if _is_tree(path) for found in fix_tree(path)]


def _is_tree(path: Path) -> bool:
    from stretch_bt.tree.headings import FORMAT

    return FORMAT in path.read_text("utf-8", errors="replace")[:2000]


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
