"""`stretch-bt sweep`."""

from __future__ import annotations

import sys
import time
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.cli.output import EXIT_FAILURE, emit_json, in_place
from stretch_bt.cli.rows import add_row

if TYPE_CHECKING:
    from rich.table import Table

    from stretch_bt.sweep import Swept

__all__ = ["command"]

#: time between two lines of progress that no terminal shows in place, s
APART = 60.0


def command(
    file: Annotated[str, typer.Argument(help="A sweep file.")],
    engine: Annotated[
        str | None,
        typer.Option(help="serial (the default), local (joblib) or dask (the default with --scheduler)."),
    ] = None,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, as in tcp://lab:8786.")] = None,
    workers: Annotated[
        int | None, typer.Option(help="How many processes on this machine; by default one for each core.")
    ] = None,
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on in the folder --out: run what has no row there, was killed or timed out."),
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder of rows, summary and pictures; by default a new one under runs/.")
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Run a tree for many scenes, seeds and params, here or on other machines."""
    from stretch_bt.sweep import sweep
    from stretch_bt.sweep.engines import engine_of

    shown = _Progress()
    with redirect_stdout(sys.stderr):  # what nodes print must not get among the summary
        chosen = engine_of(engine, workers, scheduler, shown.say)
        if resume and out is not None and not out.exists():
            shown.say(f"{out} is not there: there is nothing to go on with, and the sweep begins")
        found = sweep(file, chosen, out=out, resume=resume, progress=shown)
    shown.end()
    if json_:
        emit_json(found.to_json())
    else:
        _show(found)
    raise typer.Exit(0 if found.whole else EXIT_FAILURE)


class _Progress:
    """Says on standard error how many items were run, how many failed, and the time that is left: in place on a terminal."""

    def __init__(self) -> None:
        self._began = self._told = time.perf_counter()
        self._failed = 0
        self._terminal = sys.stderr.isatty()

    def __call__(self, row: dict[str, Any], done: int, of: int) -> None:
        """Take a row."""
        self._failed += row["status"] != "SUCCESS"
        now = time.perf_counter()
        if self._terminal or now - self._told >= APART:
            self._told = now
            left = (of - done) * (now - self._began) / done
            self.say(f"{done} of {of} items, {self._failed} without SUCCESS, {_minutes(left)} left")

    def say(self, text: str) -> None:
        """Say something in place of what was said before it."""
        if self._terminal:
            in_place(text, longest=None)
        else:
            typer.echo(text, err=True)

    def end(self) -> None:
        """Make room for what comes after it."""
        in_place("")


def _minutes(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _show(found: Swept) -> None:
    """Print a summary for a person."""
    from rich.console import Console

    from stretch_bt.sweep.summary import MOST_REASONS

    console, summary = Console(), found.summary
    ended = ", ".join(f"{count} {status}" for status, count in sorted(summary.statuses.items()))
    before = f", {found.before} of them from before" if found.before else ""
    console.print(f"{sum(summary.statuses.values())} of {summary.items} items{before}: {ended}", highlight=False)
    if found.stopped:
        text = f"{found.stopped} items were ended by a signal to their process; run again with --resume"
        console.print(text, style="yellow", highlight=False)
    for group in summary.groups.values():
        console.print(_table(group.to_json(), group.name))
        for reason, count in group.reasons.most_common(MOST_REASONS):
            console.print(f"  {count} x {reason}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    cpu = summary.to_json()["cpu_seconds"]
    if cpu is not None:
        text = f"{_minutes(cpu['sum'])} of CPU, {cpu['median']:.2f} s an item (p95 {cpu['p95']:.2f} s), wall {_minutes(found.wall_seconds)}"
        console.print(text, style="dim", highlight=False)
    console.print(f"folder: {found.folder}", style="dim", markup=False, soft_wrap=True)


def _table(group: dict[str, Any], name: str) -> Table:
    """Return the outputs of a group beside the truth."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="dim", title=escape(name), title_justify="left")
    for heading in ("output", "mean", "spread", "stated sd", "truth", "rms error", "error/sd", "unit", "items"):
        table.add_column(heading, justify="left" if heading in ("output", "unit") else "right")
    for output, about in group["outputs"].items():
        figures = (about[key] for key in ("mean", "spread", "stated_sd", "truth", "rms_error", "error_over_sd"))
        add_row(table, output, *("" if f is None else f"{f:.4g}" for f in figures), about["unit"], str(about["count"]))
    return table
