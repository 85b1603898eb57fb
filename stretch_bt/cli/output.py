"""What commands print, and the exit codes that scripts rely on."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from stretch_bt.hardware.finding import Finding

from stretch_bt.cli.outlet import answers
from stretch_bt.cli.stops import EXIT_BAD_INPUT, EXIT_INTERRUPTED, stops
from stretch_bt.errors import (
    DeviceFault,
    Diagnostic,
    FileError,
    InvalidInput,
    MissingExtra,
    NoAnswer,
    StretchError,
    writable,
)
from stretch_bt.runtime.signals import signals

__all__ = [
    "EXIT_BAD_INPUT",
    "EXIT_FAILURE",
    "EXIT_FAULT",
    "EXIT_INTERRUPTED",
    "AsJson",
    "emit_json",
    "exit_code",
    "in_place",
    "print_diagnostics",
    "print_findings",
    "report_error",
    "warn",
]

EXIT_FAILURE, EXIT_FAULT = 1, 3
#: longest line that is shown in place of another, in characters: what a terminal wraps is not taken away
_LINE = 70

AsJson = Annotated[bool, typer.Option("--json", help="Print as JSON.")]


def emit_json(document: Any, *, indent: int | None = 2, last: bool = True) -> None:
    """Print the one JSON document of a command, whole; where it is not the `last` thing done, a signal that comes meanwhile counts after it."""
    text = _text(document, indent)
    heard: list[str] = []
    with signals(heard.append):
        stops.told = True
        typer.echo(text, file=answers.stream)
    if heard and not last:
        stops(heard[0])


def _text(document: Any, indent: int | None) -> str:
    """Return a document as its reader's encoding holds it; a path that is no UTF-8 is held by no other than escapes."""
    text = json.dumps(document, indent=indent, allow_nan=False, ensure_ascii=False)
    try:
        text.encode(getattr(answers.stream or sys.stdout, "encoding", None) or "utf-8")
    except UnicodeEncodeError:
        return json.dumps(document, indent=indent, allow_nan=False)
    return text


def exit_code(error: StretchError) -> int:
    """Return the exit code of an error."""
    if isinstance(error, FileError | InvalidInput | MissingExtra):
        return EXIT_BAD_INPUT
    return EXIT_FAULT if isinstance(error, DeviceFault) and not isinstance(error, NoAnswer) else EXIT_FAILURE


def report_error(error: StretchError) -> int:
    """Say what is wrong on standard error, and return the exit code."""
    if isinstance(error, FileError):
        print_diagnostics(error.diagnostics, err=True)
    else:
        kind = (
            "device fault"
            if isinstance(error, DeviceFault)
            else "no answer"
            if isinstance(error, NoAnswer)
            else "error"
        )
        typer.secho(f"{kind}: {writable(error)}", fg=typer.colors.RED, err=True)
    for note in getattr(error, "__notes__", ()):
        typer.secho(writable(note), fg=typer.colors.RED, err=True)
    return exit_code(error)


def warn(text: str) -> None:
    """Warn of something on standard error."""
    typer.secho(f"warning: {text}", fg=typer.colors.YELLOW, err=True)


def in_place(text: str, longest: int | None = _LINE) -> None:
    """Show on a terminal, on standard error, what goes on now, in place of what was before it; nothing elsewhere."""
    if sys.stderr.isatty():
        typer.echo(f"\r\033[K{text[:longest]}", nl=False, err=True)


def print_findings(findings: Iterable[Finding], json_: bool) -> bool:
    """Print each finding as it comes, or all as JSON, and return whether all are well."""
    kept = []
    for finding in findings:
        kept.append(finding)
        if not json_:
            mark, color = ("ok", typer.colors.GREEN) if finding.ok else ("no", typer.colors.RED)
            typer.secho(f"{mark}  {finding.check}: {finding.detail}", fg=color)
            if finding.fix:
                typer.echo(f"    {finding.fix}")
    if json_:
        emit_json([finding.to_json() for finding in kept])
    return all(finding.ok for finding in kept)


def print_diagnostics(diagnostics: Iterable[Diagnostic], *, err: bool = False) -> None:
    """Print each finding with the line that it speaks of."""
    lines: dict[str, list[str]] = {}
    for finding in diagnostics:
        color = typer.colors.RED if finding.severity == "error" else typer.colors.YELLOW
        typer.secho(str(finding), fg=color, err=err)
        if finding.file not in lines:
            lines[finding.file] = _lines(finding.file)
        if 0 < finding.line <= len(lines[finding.file]):
            _excerpt(finding, lines[finding.file][finding.line - 1], err)


def _lines(file: str) -> list[str]:
    from stretch_bt.source import lines_of
    from stretch_bt.tree.program import find_tree

    try:
        path = find_tree(file)[0]
    except FileError:
        return []
    try:
        return lines_of(path.read_text("utf-8-sig")) if path.is_file() and path.stat().st_size < 2_000_000 else []
    except (OSError, UnicodeDecodeError):
        return []


def _excerpt(finding: Diagnostic, text: str, err: bool) -> None:
    if len(text) > 200:
        return
    number = f"{finding.line:5d} | "
    before, after = _printable(text[: finding.column - 1]), _printable(text[finding.column - 1 :])
    marked = _printable(text[finding.column - 1 : finding.column - 1 + finding.length])
    typer.echo(f"{number}{before}{after}", err=err)
    typer.echo(f"{' ' * (len(number) - 2)}| {' ' * len(before)}{'^' * max(1, len(marked))}", err=err)


def _printable(text: str) -> str:
    """Return a line with what a terminal would swallow, or obey, escaped."""
    return "".join(c if c.isprintable() or c == "\t" else repr(c)[1:-1] for c in text)
