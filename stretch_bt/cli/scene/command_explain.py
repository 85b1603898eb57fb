"""`stretch-bt scene explain`."""

from __future__ import annotations

import gc
import math
import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.cli.output import AsJson, emit_json

if TYPE_CHECKING:
    from rich.table import Table

    from stretch_bt.simulation.advisor.advise import Verdict
    from stretch_bt.simulation.advisor.choose import Chosen
    from stretch_bt.simulation.advisor.predict import Predicted
    from stretch_bt.simulation.scene import Scene

__all__ = ["command"]

_WIDE = 130


def command(
    scene: Annotated[str, typer.Argument(help="A scene file, or the name of a shipped scene.")],
    tolerance: Annotated[
        list[str] | None, typer.Option(help="Tolerance in place of the scene's, as in stiffness=2%; may be repeated.")
    ] = None,
    json_: AsJson = False,
) -> None:
    """Show which effects a scene simulates, how large each one is against the tolerance, and why."""
    began = time.process_time()
    from stretch_bt.simulation.advisor.advise import advise
    from stretch_bt.simulation.advisor.choose import choose
    from stretch_bt.simulation.advisor.demand import demand
    from stretch_bt.simulation.advisor.told import to_json
    from stretch_bt.simulation.scene import load_scene
    from stretch_bt.simulation.scene.asked import asked_pairs, read_asked

    read = demand(load_scene(scene), read_asked(asked_pairs(tolerance)) if tolerance else None)
    read.object.rough()  # which may read a table
    gc.freeze()  # the collector need not walk through the models of all objects and effects again
    ready = time.process_time()
    chosen = choose(read)
    verdicts = advise(read, chosen)
    done = time.process_time()
    if json_:
        emit_json(
            {
                "scene": read.name,
                "tolerance": {**read.kept, **read.asked},
                "fidelity": read.fidelity,
                "camera": read.camera,
                "effects": [verdict.to_json() for verdict in verdicts],
                "left_off": [_left_off(p) for p in _too_much(chosen)],
                "choice": to_json(read, chosen),
                "seconds": done - ready,
            }
        )
        return
    _show(read, verdicts, chosen)
    typer.secho(
        f"decided in {1e3 * (done - ready):.2f} ms of CPU; loading objects and effects and reading the scene took "
        f"{1e3 * (ready - began):.0f} ms",
        dim=True,
    )


def _too_much(chosen: Chosen) -> list[Predicted]:
    """Return the results that what is off may change by more than their tolerance, if all of it adds up."""
    return [p for p in chosen.predicted.values() if p.total - (p.solver or 0.0) > p.tolerance]


def _left_off(predicted: Predicted) -> dict[str, Any]:
    return {
        "observable": predicted.observable,
        "estimate": None if math.isinf(predicted.total) else predicted.total - (predicted.solver or 0.0),
        "threshold": predicted.tolerance,
        "names": list(predicted.left_off),
    }


def _show(scene: Scene, verdicts: list[Verdict], chosen: Chosen) -> None:
    from rich.console import Console
    from rich.markup import escape

    from stretch_bt.simulation.advisor.told import line, narrow, quantity

    console = Console()
    if not console.is_terminal:
        console.width = 2 * _WIDE  # a line for each effect, for grep
    tolerances = ", ".join(f"{name} {quantity(name, value)}" for name, value in {**scene.kept, **scene.asked}.items())
    console.print(
        f"[bold]{escape(scene.name)}[/]: {scene.fidelity} fidelity, camera {scene.camera}; tolerance {tolerances}"
    )
    judged = [v for v in verdicts if v.possible]
    console.print(_table(judged, reasons=console.width >= _WIDE))
    for verdict in judged if console.width < _WIDE else ():
        console.print(f"{verdict.name}: {verdict.why}", style="dim", markup=False, highlight=False)
    for reason, names in _impossible(verdicts).items():
        console.print(f"{reason}: {', '.join(names)}", style="dim", markup=False, highlight=False)
    console.print(line(scene, chosen), markup=False, highlight=False, soft_wrap=True)
    if (told := narrow(scene, chosen)) is not None:
        console.print(told, style="yellow", markup=False, highlight=False, soft_wrap=True)


def _impossible(verdicts: list[Verdict]) -> dict[str, list[str]]:
    """Return by its reason what the scene cannot have."""
    found: dict[str, list[str]] = {}
    for verdict in verdicts:
        if not verdict.possible:
            said = verdict.name.replace("_", " ")
            reason = verdict.why.removesuffix(said).strip()  # "a sphere cannot have", and then the names
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
        size = "unknown" if v.observable and v.estimate is None else _of(v, v.estimate)
        cells = [v.name, state, v.observable or "", size, _of(v, v.threshold), cost]
        table.add_row(*cells, *([v.why] if reasons else []))
    return table


def _of(verdict: Verdict, value: float | None) -> str:
    from stretch_bt.simulation.advisor.told import quantity

    return "" if value is None or verdict.observable is None else quantity(verdict.observable, value)
