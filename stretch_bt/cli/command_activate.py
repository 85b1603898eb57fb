"""`stretch-bt activate`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import EXIT_FAILURE, AsJson, emit_json
from stretch_bt.errors import InvalidInput

if TYPE_CHECKING:
    from stretch_bt.clock import Clock
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.interfaces import MotionState
    from stretch_bt.hardware.monitored.gripper import MonitoredGripper

__all__ = ["command"]

_TICK = 0.05


def command(
    cell: Annotated[str, typer.Argument(help="A cell file, or the name of a shipped cell.")],
    device: Annotated[str | None, typer.Option("--device", help="Which gripper, where the cell has several.")] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Do not ask: the membrane is off, and nobody is near the fingers.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """Activate a gripper, which opens and closes its fingers all the way: take the membrane off and keep clear of them."""
    from stretch_bt.clock import RealClock
    from stretch_bt.hardware.cell import open_cell
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.hardware.driver import GripperDriver
    from stretch_bt.hardware.monitored.gripper import MonitoredGripper
    from stretch_bt.runtime.use_cell import use_cell

    spec = load_cell(cell)
    grippers = [name for name, d in spec.devices.items() if d.type == "Gripper" and device in (None, name)]
    if not grippers:
        named = f" called {device!r}" if device else ""
        raise InvalidInput(f"{spec.path.name} has no gripper{named}; name a cell with one")
    if len(grippers) > 1:
        raise InvalidInput(f"{spec.path.name} has the grippers {', '.join(grippers)}; name one with --device")
    if spec.devices[grippers[0]].use == "simulated":
        raise InvalidInput("a simulated gripper needs no activation")
    driver = spec.devices[grippers[0]].implementation.cls
    if getattr(driver, "activate", None) is GripperDriver.activate:
        raise InvalidInput(f"{grippers[0]} needs no activation: its driver, {driver.__name__}, has none")
    if not yes:
        text = f"{grippers[0]}: the fingers will travel all their way. Is the membrane off, and is everybody clear of them?"
        typer.confirm(text, abort=True, err=True)
    clock = RealClock()

    def activate(opened: Cell) -> tuple[MotionState, float]:
        gripper = opened.devices[grippers[0]]
        assert isinstance(gripper, MonitoredGripper)
        return _activate(gripper, clock), gripper.opening(1.0).value

    state, opening = use_cell(lambda: open_cell(spec, now=clock.now, only=grippers), activate)
    if json_:
        emit_json({"device": grippers[0], "state": str(state), "opening": opening})
    else:
        typer.echo(f"{grippers[0]}: {'activated' if state == 'done' else state}, opening {opening * 1e3:.1f} mm")
    raise typer.Exit(0 if state == "done" else EXIT_FAILURE)


def _activate(gripper: MonitoredGripper, clock: Clock) -> MotionState:
    motion = gripper.activate(owner="activate")
    while (state := motion.poll()) == "moving":
        clock.wait_until(clock.now() + _TICK)
    return state
