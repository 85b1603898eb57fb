"""`stretch-bt run`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.blame import blame
from stretch_bt.cli.outlet import pictures
from stretch_bt.cli.output import (
    EXIT_BAD_INPUT,
    EXIT_FAILURE,
    EXIT_FAULT,
    EXIT_INTERRUPTED,
    emit_json,
    exit_code,
    report_error,
)
from stretch_bt.cli.rows import add_row
from stretch_bt.cli.stops import stops
from stretch_bt.errors import FileError, InvalidInput, StretchError, writable

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from stretch_bt.runtime.runner import Runner
    from stretch_bt.runtime.task import RunResult

__all__ = ["command"]

_EXIT = {
    "SUCCESS": 0,
    "FAILURE": EXIT_FAILURE,
    "ERROR": EXIT_FAILURE,
    "FAULT": EXIT_FAULT,
    "INTERRUPTED": EXIT_INTERRUPTED,
}
_COLOR = {"SUCCESS": "green", "FAILURE": "yellow"}
_SI = {"position": "m", "rotation": "rad", "force": "N", "torque": "N m", "opening": "m", "time": "s"}


def command(
    tree: Annotated[str, typer.Argument(help="A tree file, or the name of a shipped tree.")],
    scene: Annotated[str | None, typer.Option(help="What is simulated: a scene file, or a shipped scene.")] = None,
    cell: Annotated[str | None, typer.Option(help="Which devices are used: a cell file, or a shipped cell.")] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", help="A param, as in depth=2mm; may be repeated.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random in a simulation.")] = 0,
    mocks: Annotated[str | None, typer.Option(help="A mocks file.")] = None,
    out: Annotated[Path | None, typer.Option(help="The record's folder; by default a new one under runs/.")] = None,
    record: Annotated[
        str, typer.Option(help="What is kept of the run: full, events (no readings, no report) or none.")
    ] = "full",
    tolerance: Annotated[
        list[str] | None,
        typer.Option(help="Tolerance of the twin, as in stiffness=2%; may be repeated."),
    ] = None,
    longest: Annotated[
        str, typer.Option(help="Virtual time after which a simulated or mocked run is ended, as in '10 h'.")
    ] = "2 h",
    stats: Annotated[
        bool, typer.Option("--stats", help="Show what the twin solved, and the time of each effect.")
    ] = False,
    traceback: Annotated[
        bool, typer.Option("--traceback", help="Show where the code of a node broke, frame by frame.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Do not show the tree while it runs.")] = False,
    json_: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Run a tree on a scene, on a cell, or on mocks."""
    try:
        options = {"scene": scene, "cell": cell, "seed": seed, "mocks": mocks, "out": out, "record": record}
        result = _ran(tree, not quiet, set_ or [], longest=longest, tolerance=_asked(tolerance), **options)
    except StretchError as error:
        stops.way = "note"
        raise typer.Exit(_say_refused(error, traceback=traceback, json_=json_)) from None
    stops.way = "note"
    raise typer.Exit(_say_ended(result, traceback=traceback, stats=stats, json_=json_))


def _ran(tree: str, shown: bool, set_: list[str], longest: str, **options: Any) -> RunResult:
    """Run the tree; a signal after the task had ended is in the result."""
    from stretch_bt.runtime.result import interrupt_result
    from stretch_bt.runtime.task import run
    from stretch_bt.units import parse_time

    options["longest"] = parse_time("--longest", longest)
    view = _view() if shown else None
    # what nodes print must not get among the result, and no tick waits for whoever reads it
    with pictures():
        # from the first tick on the run ends by itself
        result = run(tree, params=params_of(set_), view=view, watch=_noted, **options)
    if stops.names:
        interrupt_result(result, stops.names[0])
    return result


def _asked(given: list[str] | None) -> dict[str, str] | None:
    if not given:
        return None
    from stretch_bt.simulation.scene.asked import asked_pairs

    return asked_pairs(given)


def _say_refused(error: StretchError, *, traceback: bool, json_: bool) -> int:
    """Print why a run did not begin, and return the exit code; what is no bad input is a result like any other."""
    code = exit_code(error)
    if json_:
        emit_json(refused(error))
    elif code != EXIT_BAD_INPUT:
        from rich.console import Console

        show(_unbegun(error), Console(), traceback)
        return code
    report_error(error)
    if traceback and (broken := blame(error)) is not None:
        typer.echo(broken["traceback"], err=True)
    return code


def _say_ended(result: RunResult, *, traceback: bool, stats: bool, json_: bool) -> int:
    """Print how a run ended, and return the exit code."""
    from rich.console import Console

    if json_:
        emit_json(printed(result, stats=stats))
    show(result, Console(stderr=json_), traceback)
    if stats:
        show_stats(result, Console(stderr=json_))
    return EXIT_FAILURE if result.unmet and result.status == "SUCCESS" else _EXIT[result.status]


def _noted(_: Runner) -> None:
    stops.way = "note"


def _view() -> Any:
    from stretch_bt.runtime.live import LiveView

    return LiveView()


def params_of(given: list[str]) -> dict[str, str]:
    """Return the params of `--set`, as name: text."""
    found: dict[str, str] = {}
    for item in given:
        name, equals, value = (part.strip() for part in item.partition("="))
        if not equals or not name:
            raise InvalidInput(f"--set takes name=value, not {item!r}; write --set depth=2mm")
        if found.setdefault(name, value) != value:
            raise InvalidInput(f"{name!r} is set to {found[name]!r} and to {value!r}; give --set {name}=... once")
    return found


def refused(error: StretchError) -> dict[str, Any]:
    """Return the JSON of a run that did not begin."""
    found = [d.to_json() for d in error.diagnostics] if isinstance(error, FileError) else []
    return {**printed(_unbegun(error)), "diagnostics": found}


def _unbegun(error: StretchError) -> RunResult:
    """Return the result of a run that an error ended before the first tick."""
    from stretch_bt.runtime.task import RunResult

    status = "FAULT" if exit_code(error) == EXIT_FAULT else "ERROR"
    result = RunResult.without_ticks(status, writable(error), error.record)
    result.errors += map(writable, getattr(error, "__notes__", ()))
    broken = blame(error)
    result.broken += [] if broken is None else [broken]
    return result


def printed(result: RunResult, *, stats: bool = False) -> dict[str, Any]:
    """Return the fields of a result that `--json` prints."""
    return {key: value for key, value in result.to_json().items() if stats or key != "stats"}


def show(result: RunResult, console: Console, traceback: bool = False) -> None:
    """Print a result for a person; `traceback` adds every frame where the code of a node broke."""
    color = _COLOR.get(result.status, "red")
    console.print(f"[bold {color}]{result.status}[/]", end=" " if result.reason else "\n")
    if result.reason:
        console.print(result.reason, markup=False, highlight=False)
    for broken in result.broken:
        console.print(f"  at {broken['at']}", markup=False, highlight=False, soft_wrap=True)
        if traceback:
            console.print(broken["traceback"], markup=False, highlight=False, soft_wrap=True)
    if result.outputs:
        console.print(outputs_table(result))
    for name, value in result.readings.items() if result.status != "SUCCESS" else ():
        console.print(
            f"  {name}: {in_words(value, name.rpartition('.')[2])}", markup=False, highlight=False, soft_wrap=True
        )
    for text in result.notes:
        console.print(text, style="yellow", markup=False, highlight=False, soft_wrap=True)
    for text in [*result.errors, *result.unmet]:
        console.print(f"  {text}", style="red", markup=False, highlight=False)
    if result.choice is not None and result.choice["asked"]:
        console.print(result.choice["line"], markup=False, highlight=False, soft_wrap=True)
        if result.choice["narrow"]:
            console.print(result.choice["narrow"], style="yellow", markup=False, highlight=False, soft_wrap=True)
    times = f"{result.ticks} ticks, {result.task_seconds:.1f} s of the task in {result.cpu_seconds:.1f} s of CPU"
    overruns = f", {result.overruns} ticks late" if result.overruns else ""
    console.print(times + overruns, style="dim")
    if result.record is not None:
        console.print(f"record: {result.record}", style="dim", markup=False, soft_wrap=True)


def in_words(value: Any, name: str = "") -> str:
    """Return a reading on one line, its numbers short and with their SI unit."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {in_words(item, key)}" for key, item in value.items())
    text = f"({', '.join(_number(item) for item in value)})" if isinstance(value, list) else _number(value)
    return f"{text} {_SI[name]}" if name in _SI else text


def outputs_table(result: RunResult) -> Table:
    """Return the outputs beside the truth."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("output", "value", "sd", "unit", "truth", "error"):
        table.add_column(heading, justify="left" if heading in ("output", "unit") else "right")
    for name, output in result.outputs.items():
        truth = result.truth.get(name, {}).get("value")
        value, sd = output["value"], output["sd"]
        error = f"{100 * (value / truth - 1):+.1f} %" if truth else ""
        cells = (_number(value), _number(sd), output["unit"], _number(truth), error)
        add_row(table, name, *cells)
    return table


def show_stats(result: RunResult, console: Console) -> None:
    """Print what the twin did, the cost of that, and the rest of the run's CPU time."""
    from rich.table import Table

    if not result.stats:
        console.print("no twin: nothing was simulated in this run", style="dim")
        return
    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("of the twin", "kind", "count", "CPU ms", "each, us"):
        table.add_column(heading, justify="left" if heading in ("of the twin", "kind") else "right")
    for row in result.stats:
        add_row(table, row["name"], row["group"], str(row["count"]), *_times(row))
    rest = result.cpu_seconds - sum(row["cpu_seconds"] or 0.0 for row in result.stats)
    table.add_row("all else", "nodes, ticks, record", "", f"{max(rest, 0.0) * 1e3:.1f}", "")
    console.print(table)


def _times(row: dict[str, Any]) -> tuple[str, str]:
    if row["cpu_seconds"] is None:
        return f"in {row['within']}", ""
    milliseconds, each = row["cpu_seconds"] * 1e3, row["cpu_seconds"] * 1e6 / max(row["count"], 1)
    return f"{milliseconds:.1f}", f"{each:.0f}"


def _number(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, list):
        return f"[{', '.join(map(_number, value))}]"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
