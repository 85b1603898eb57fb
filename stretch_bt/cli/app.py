"""The `stretch-bt` command and what every command has in common: exit codes, and no traceback for a user's mistake."""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Annotated

import typer

import stretch_bt
from stretch_bt import cli
from stretch_bt.cli.output import EXIT_BAD_INPUT, EXIT_INTERRUPTED, emit_json, report_error
from stretch_bt.errors import StretchError
from stretch_bt.run.signals import signals

__all__ = ["app", "main"]

app = typer.Typer(
    name="stretch-bt",
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


def _add_commands(group: typer.Typer, package: ModuleType) -> None:
    """Add each `command_NAME` file of a folder as a command, and each folder in it as a group of commands."""
    for module in iter_modules(package.__path__):
        if not (module.ispkg or module.name.startswith("command_")):
            continue
        loaded = import_module(f"{package.__name__}.{module.name}")
        if module.ispkg:
            inner = typer.Typer(help=loaded.__doc__, no_args_is_help=True)
            _add_commands(inner, loaded)
            group.add_typer(inner, name=module.name)
        else:
            group.command(module.name.removeprefix("command_").replace("_", "-"))(loaded.command)


_add_commands(app, cli)


def main() -> None:
    """Run the command line."""
    interrupted = threading.Event()

    def interrupt(name: str) -> None:
        interrupted.set()
        raise KeyboardInterrupt

    with signals(interrupt):
        try:
            app()
        except StretchError as error:
            if "--json" in sys.argv:
                emit_json({"error": type(error).__name__, "reason": str(error)})
            sys.exit(report_error(error))
        except OSError as error:
            if isinstance(error, BrokenPipeError):  # whoever read the output has enough
                sys.stderr.close()
                sys.exit(0)
            typer.secho(f"error: {error}", fg=typer.colors.RED, err=True)
            sys.exit(EXIT_BAD_INPUT)
        except (KeyboardInterrupt, SystemExit) as ended:
            if interrupted.is_set() or isinstance(ended, KeyboardInterrupt):
                sys.exit(EXIT_INTERRUPTED)
            raise
