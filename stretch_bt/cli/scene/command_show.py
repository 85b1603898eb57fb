"""`stretch-bt scene show`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import warn

if TYPE_CHECKING:
    from stretch_bt.simulation.picture import Stage

__all__ = ["command"]


def command(
    scene: Annotated[str, typer.Argument(help="A scene file, or the name of a shipped scene.")],
    out: Annotated[Path | None, typer.Option(help="An .svg or .png file; NAME.svg unless given.")] = None,
) -> None:
    """Draw a scene, its pressed membrane, and the depth frame that the simulated camera sends of it."""
    from stretch_bt.simulation.picture import save_scene
    from stretch_bt.simulation.scene import load_scene

    read = load_scene(scene)
    path = out or Path(f"{read.name}.svg")
    moment = save_scene(read, path, _stage())
    reached, wanted = read.object.top - moment.pose.height, read.conditions.depth
    if moment.refusal:
        warn(f"nothing is pressed: {moment.refusal}")
    elif wanted > read.object.top:
        warn(f"the hand stands on the table: pressed {reached * 1e3:.3g} mm of {wanted * 1e3:.3g} mm")
    typer.echo(str(path))


def _stage() -> Stage:
    """Return what the simulated cell, which `run` uses by default, has of a hand and a camera."""
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.simulation.camera.sensor import window
    from stretch_bt.simulation.fidelity.make import Membrane
    from stretch_bt.simulation.picture import Stage

    cell = load_cell("simulated")
    hand = cell.hand
    name, camera = next((n, d) for n, d in cell.devices.items() if d.type == "DepthCamera")
    rate = float(camera.options.model_dump()["rate"])
    lens = window(hand.width, hand.gauge + cell.limits.stretch.max, hand.plane_distance)
    return Stage(Membrane(hand.gauge, hand.width, hand.thickness), hand.plane_distance, lens, rate, name)
