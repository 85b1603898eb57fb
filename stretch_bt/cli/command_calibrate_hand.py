"""`stretch-bt calibrate-hand`."""

from __future__ import annotations

import math
import os
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stretch_bt.cli.looking import SCENE
from stretch_bt.cli.output import AsJson, emit_json
from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.runtime.hand_calibration import HandCalibration

__all__ = ["command"]


def command(
    cell: Annotated[str, typer.Argument(help="A cell file, or the name of a shipped cell.")],
    out: Annotated[Path, typer.Option(help="Write the calibration into this file, which must not be there.")] = Path(
        "hand.yaml"
    ),
    scene: Annotated[str, typer.Option(help="What a simulated cell simulates.")] = SCENE,
    seed: Annotated[int, typer.Option(help="Of everything random in a simulation.", min=0)] = 0,
    stops: Annotated[int, typer.Option(help="Openings at which to look.", min=3, max=30)] = 6,
    frames: Annotated[int, typer.Option(help="Frames to average at each.", min=1, max=256)] = 16,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask: the hand is free, and fingers may move.")] = False,
    json_: AsJson = False,
) -> None:
    """Find where the camera stands in the hand, and which opening a count of the gripper is: the membrane is stretched and looked at."""
    from stretch_bt.hardware.cell import clock_of, open_cell
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.hardware.hand_file import written
    from stretch_bt.runtime.hand_calibration import calibrate_hand, hand_devices
    from stretch_bt.runtime.use_cell import use_cell
    from stretch_bt.simulation.scene import load_scene

    spec = load_cell(cell)
    if out.exists() or not out.parent.is_dir():
        raise InvalidInput(
            f"{out}: {'it is there already' if out.exists() else 'there is no such folder'}; name another file with --out"
        )
    if not os.access(out.parent, os.W_OK):
        raise InvalidInput(f"{out}: its folder may not be written to; name another file with --out")
    wanted = hand_devices(spec)
    classes = [spec.devices[name].implementation.cls for name in wanted]
    if not (yes or classes[0].simulated):
        low, high = spec.span("stretch")
        way = f"from {1e3 * max(low, 0.0):.0f} to {1e3 * high:.0f} mm"
        text = f"The fingers will stretch the membrane {way}. Does it touch nothing, and is everybody clear of it?"
        typer.confirm(text, abort=True, err=True)
    clock = clock_of(spec, wanted)
    simulates = load_scene(scene) if any(cls.simulated for cls in classes) else None
    found = use_cell(
        lambda: open_cell(spec, clock=clock, seed=seed, scene=simulates, only=wanted),
        lambda opened: calibrate_hand(
            opened, clock, stops=stops, frames=frames, said=lambda text: typer.echo(text, err=True)
        ),
    )
    fields = _fields(found, spec, frames)
    emit_json(fields) if json_ else _show(fields)  # minutes of the robot are not lost with a disk
    with out.open("x", encoding="utf-8") as file:  # one that came meanwhile is kept
        file.write(written(fields))
    if not json_:
        typer.echo(f"written: {out}; name it in the cell file as 'hand: {{calibration: {out.name}}}'")


def _fields(found: HandCalibration, spec: CellSpec, frames: int) -> dict[str, Any]:
    """Return the calibration as JSON has it, SI."""
    return {
        "camera": {name: {"value": float(e), "sd": e.sd} for name, e in found.camera.items()},
        "gripper": {
            "ratio": {"value": float(found.ratio), "sd": found.ratio.sd},
            "points": [{"count": count, "opening": float(e), "sd": e.sd} for count, e in found.points],
        },
        "residuals": {
            "length": found.residual,
            "lengths": [float(stop.view.length) for stop in found.stops],
            "told": [stop.told for stop in found.stops],
            "counts": [stop.count for stop in found.stops],
        },
        "provenance": {
            "cell": spec.path.name,
            "made": datetime.now().astimezone().isoformat(timespec="seconds"),
            "frames": frames,
        },
    }


def _show(fields: dict[str, Any]) -> None:
    from stretch_bt.hardware.hand_file import TURNS

    for name, e in fields["camera"].items():
        unit, scale = ("deg", math.degrees(1)) if name in TURNS else ("mm", 1e3)
        typer.echo(f"{name:10} {scale * e['value']:9.3f} +- {scale * e['sd']:.3f} {unit}")
    ratio = fields["gripper"]["ratio"]
    typer.echo(f"openings seen over openings reported: {ratio['value']:.4f} +- {ratio['sd']:.4f}")
    for point in fields["gripper"]["points"]:
        typer.echo(f"count {point['count']:3d} is {1e3 * point['opening']:.2f} +- {1e3 * point['sd']:.2f} mm")
