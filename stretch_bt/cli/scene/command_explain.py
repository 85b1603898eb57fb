"""`stretch-bt scene explain`."""

from __future__ import annotations

import gc
import time
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import emit_json

if TYPE_CHECKING:
    from rich.table import Table

    from stretch_bt.simulation.advisor.advise import LeftOff, Verdict
    from stretch_bt.simulation.scene import Scene

__all__ = ["command"]

_LENGTHS = ("height", "size")
_LEAST = 1e-3  # mm or per cent; below that a size is as good as none
_WIDE = 130


def command(
    scene: Annotated[str, typer.Argument(help="A scene file, or the name of a shipped scene.")],
    json_: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Show which effects a scene simulates, how large each one is against the tolerance, and why."""
    began = time.process_time()
    from stretch_bt.simulation.advisor.advise import advise, left_off
    from stretch_bt.simulation.scene import load_scene

    read = load_scene(scene)
    read.object.rough()  # which may read a table
    gc.freeze()  # the collector need not walk through the models of all objects and effects again
    ready = time.process_time()
    verdicts = advise(read)
    done = time.process_time()
    if json_:
        emit_json(
            {
                "scene": read.name,
                "tolerance": read.tolerance.named(),
                "fidelity": read.fidelity,
                "camera": read.camera,
                "effects": [verdict.to_json() for verdict in verdicts],
                "left_off": [asdict(left) for left in left_off(verdicts)],
                "seconds": done - ready,
            }
        )
        return
    _show(read, verdicts)
    typer.secho(
        f"decided in {1e3 * (done - ready):.2f} ms of CPU; loading objects and effects and reading the scene took "
        f"{1e3 * (ready - began):.0f} ms",
        dim=True,
    )


def _show(scene: Scene, verdicts: list[Verdict]) -> None:
    from rich.console import Console

    from stretch_bt.simulation.advisor.advise import left_off

    console = Console()
    if not console.is_terminal:
        console.width = 2 * _WIDE  # a line for each effect, for grep
    tolerances = ", ".join(f"{name} {quantity(name, value)}" for name, value in scene.tolerance.named().items())
    console.print(f"[bold]{scene.name}[/]: {scene.fidelity} fidelity, camera {scene.camera}; tolerance {tolerances}")
    judged = [v for v in verdicts if v.possible]
    console.print(_table(judged, reasons=console.width >= _WIDE))
    for verdict in judged if console.width < _WIDE else ():
        console.print(f"{verdict.name}: {verdict.why}", style="dim", markup=False, highlight=False)
    for reason, names in _impossible(verdicts).items():
        console.print(f"{reason}: {', '.join(names)}", style="dim", markup=False, highlight=False)
    for verdict in verdicts:
        if verdict.near:
            console.print(f"warning: {_close(verdict)}", style="yellow", markup=False, highlight=False)
    for left in left_off(verdicts):
        console.print(f"warning: {_together(left)}", style="yellow", markup=False, highlight=False)


def _impossible(verdicts: list[Verdict]) -> dict[str, list[str]]:
    """Return by its reason what the scene cannot have."""
    found: dict[str, list[str]] = {}
    for verdict in verdicts:
        if not verdict.possible:
            said = verdict.name.replace("_", " ")
            reason = verdict.why.removesuffix(said).strip()  # "a cup has no", and then the names
            found.setdefault(reason, []).append(verdict.name)
    return found


def _table(verdicts: list[Verdict], *, reasons: bool) -> Table:
    from rich.table import Table

    from stretch_bt.simulation.effects import registry

    table = Table(box=None, pad_edge=False, header_style="dim")
    for heading in ("effect", "", "changes", "by", "tolerance", "cost", *(["why"] if reasons else [])):
        table.add_column(heading, justify="right" if heading in ("by", "tolerance", "cost") else "left")
    for v in verdicts:
        cost = f"{v.cost_ms:.3g} ms/{registry()[v.name].cost_per}"
        state = "[green]on[/]" if v.on else "[dim]off[/]"
        cells = [v.name, state, v.observable or "", _of(v, v.estimate), _of(v, v.threshold), cost]
        table.add_row(*cells, *([v.why] if reasons else []))
    return table


def _of(verdict: Verdict, value: float | None) -> str:
    return "" if value is None or verdict.observable is None else quantity(verdict.observable, value)


def _close(verdict: Verdict) -> str:
    size, limit = _of(verdict, verdict.estimate), _of(verdict, verdict.threshold)
    state, other = ("on", "off") if verdict.on else ("off", "on")
    return (
        f"{verdict.name} is {state} by a narrow margin: {verdict.observable} {size} against {limit}; "
        f"write 'effects: {{{verdict.name}: {other}}}' if you know better"
    )


def _together(left: LeftOff) -> str:
    total, limit = quantity(left.observable, left.estimate), quantity(left.observable, left.threshold)
    return f"what is off may add up to {left.observable} {total} against {limit}: {', '.join(left.names)}"


def quantity(observable: str, value: float) -> str:
    """Return a value of an observable, SI, in the unit that people use: mm, or per cent."""
    number, unit = (value * 1e3, "mm") if observable in _LENGTHS else (value * 100, "%")
    return f"< {_LEAST:g} {unit}" if 0 < number < _LEAST else f"{number:.3g} {unit}"
