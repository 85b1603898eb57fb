"""The `stretch-bt` command and what every command has in common: exit codes, and no traceback for a user's mistake."""

from __future__ import annotations

import errno
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

import stretch_bt
from stretch_bt import cli
from stretch_bt.cli.commands import Commands, Group
from stretch_bt.cli.output import EXIT_BAD_INPUT, emit_json, report_error
from stretch_bt.cli.start import main
from stretch_bt.cli.stops import stops
from stretch_bt.errors import InvalidInput, StretchError, writable

__all__ = ["app", "carry_out", "main", "notes_of"]


COMMANDS = Commands(cli)


class _Commands(Group):
    """All commands; the reason why one ends before it began is kept for its JSON."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands: Any = COMMANDS

    def invoke(self, ctx: Any) -> Any:
        """Carry out the command that was named."""
        try:
            return super().invoke(ctx)
        except typer.Abort:
            stops.reason = "nobody said yes to the question; answer it, or pass --yes"
            raise
        except Exception as error:
            if hasattr(error, "format_message"):  # of words that the command does not take
                _in_plain_words(error)
                stops.reason = " ".join(writable(error.format_message()).split())
            raise


def _in_plain_words(error: Any) -> None:
    """Replace the message of pydantic, with which typer reads values, by one in this package's words."""
    from pydantic import ValidationError

    from stretch_bt.source.plain_words import in_words

    if isinstance(error.__cause__, ValidationError):
        told = error.__cause__.errors(include_url=False)[0]
        said, hint = in_words(told, repr(told["input"]))
        error.message = f"it{said}; {hint}".removeprefix("it: ")


app = typer.Typer(
    name="stretch-bt",
    cls=_Commands,
    help="Behaviour trees for the StRETcH tactile hand.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(stretch_bt.__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


#: what to do where the system refuses a file
_REMEDIES = {
    errno.ENOENT: "correct the name, or make its folder first",
    errno.EISDIR: "it is a folder; name a file in it",
    errno.EEXIST: "name another one, or move it away",
    errno.ENOTDIR: "a file is where a folder is wanted; name another path",
    errno.EACCES: "name a place that you may write to, or change its rights",
    errno.EPERM: "name a place that you may write to, or change its rights",
    errno.EROFS: "name a place that you may write to",
    errno.ENOSPC: "make room, or name a place on another disk",
    errno.ENAMETOOLONG: "name a shorter one",
}


def _told(error: OSError) -> str:
    """Return an error of the system; one without a file is most often of a current folder that somebody removed."""
    try:
        Path.cwd()
    except FileNotFoundError:
        return "the current folder is gone, and a path is relative to it; go to a folder that is there (cd), or name full paths"
    remedy = _REMEDIES.get(error.errno or 0)
    what = writable(error) if error.filename is None else f"{error.filename}: {error.strerror}"
    return what + (f"; {remedy}" if remedy else "")


def _check_given(words: list[str]) -> None:
    """Refuse a word without a letter, as an unset variable of a shell leaves it: the default would take its place in silence."""
    for before, word in zip(["", *words], words, strict=False):
        name, _, value = word.partition("=")
        if word == "" and before.startswith("--"):
            raise InvalidInput(f"{before} is empty; give it a value, or leave it out")
        if word == "":
            raise InvalidInput("an argument is empty; give it a value, or leave it out")
        if name.startswith("--") and "=" in word and not value:
            raise InvalidInput(f"{name} is empty; give it a value, or leave it out")


def notes_of(error: BaseException | None) -> list[str]:
    """Return the notes of an error and of those that it was raised from, as that fingers may go on."""
    found: list[str] = []
    while error is not None:
        found += getattr(error, "__notes__", [])
        error = error.__cause__ or error.__context__
    return found


def carry_out() -> None:
    """Carry out the command of `sys.argv`."""
    for name in sys.argv[1:2]:
        if name in COMMANDS:
            COMMANDS[name]  # made while a signal still ends the process at once
    if sys.argv[1:2] != ["run"]:  # which says by itself from when on something is open
        stops.way = "raise"
    try:
        _check_given(sys.argv[1:])
        app()
    except StretchError as error:
        if "--json" in sys.argv and not stops.told:
            emit_json({"error": type(error).__name__, "reason": writable(error)})
        sys.exit(report_error(error))
    except OSError as error:
        stops.reason = _told(error)
        typer.secho(f"error: {stops.reason}", fg=typer.colors.RED, err=True)
        sys.exit(EXIT_BAD_INPUT)
    except (KeyboardInterrupt, SystemExit) as stopped:
        for note in notes_of(stopped):
            typer.secho(writable(note), fg=typer.colors.RED, err=True)
        if not stops.names or stops.way == "note":
            raise
        raise KeyboardInterrupt from None
