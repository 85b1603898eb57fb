"""`stretch-bt move`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.looking import SCENE, AsJson
from stretch_bt.cli.looking import Cell as CellName
from stretch_bt.cli.output import EXIT_FAILURE, EXIT_INTERRUPTED, exit_code, print_findings
from stretch_bt.cli.quantities import quantity_of
from stretch_bt.errors import BeyondLimits, DeviceFault, InvalidInput

if TYPE_CHECKING:
    from stretch_bt.hardware.cell import Cell
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.hardware.finding import Finding

__all__ = ["command"]


def command(
    cell: CellName,
    up: Annotated[str | None, typer.Option("--up", help="How far up, as in 10mm.")] = None,
    down: Annotated[
        str | None, typer.Option("--down", help="How far down, to no lower than `limits.contact.below` of the cell.")
    ] = None,
    speed: Annotated[str, typer.Option("--speed", help="Speed of the hand.")] = "5mm/s",
    device: Annotated[str | None, typer.Option("--device", help="Which arm, where the cell has several.")] = None,
    scene: Annotated[str, typer.Option(help="What a simulated cell simulates.")] = SCENE,
    yes: Annotated[
        bool, typer.Option("--yes", help="Do not ask: nothing is in the way, and nobody is near the arm.")
    ] = False,
    json_: AsJson = False,
) -> None:
    """Move the hand straight up, or down in the air; says what it will do and asks, Ctrl-C stops, and without --up or --down nothing moves."""
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.runtime.vertical_move import arm_of, check_distance

    spec = load_cell(cell)
    name, by, fast = arm_of(spec, device), _distance(up, down), quantity_of("--speed", "Speed", speed)
    check_distance(spec, by)
    try:
        found, code = _moved(spec, name, by, fast, scene, yes=yes)
    except DeviceFault as fault:
        found, code = _faulty(name, fault), exit_code(fault)
    print_findings([found], json_)
    raise typer.Exit(code)


def _moved(spec: CellSpec, name: str, by: float, speed: float, scene: str, *, yes: bool) -> tuple[Finding, int]:
    """Open the arm, ask, and move it; return how that ended, and the exit code."""
    from stretch_bt.hardware.cell import clock_of, open_cell
    from stretch_bt.runtime.use_cell import use_cell
    from stretch_bt.runtime.vertical_move import VerticalMove
    from stretch_bt.simulation.scene import load_scene

    simulated = spec.devices[name].implementation.cls.simulated
    clock = clock_of(spec, [name])
    simulates = load_scene(scene) if simulated else None

    def move_in(opened: Cell) -> tuple[Finding, int]:
        move = VerticalMove(opened, name, by, speed)
        typer.echo(str(move), err=True)
        if not (yes or simulated):
            typer.confirm(
                "Is nothing in the way, everybody clear, and a hand on the emergency stop?", abort=True, err=True
            )
        try:
            found = move.go(clock)
        except KeyboardInterrupt:
            return move.stopped("stopped by Ctrl-C"), EXIT_INTERRUPTED
        return found, 0 if found.ok else EXIT_FAILURE

    return use_cell(lambda: open_cell(spec, clock=clock, scene=simulates, only=[name]), move_in)


def _faulty(name: str, fault: DeviceFault) -> Finding:
    from stretch_bt.hardware.examine import AS_IT_SAYS
    from stretch_bt.hardware.finding import Finding

    fix = AS_IT_SAYS
    if isinstance(fault, BeyondLimits):
        fix = "go more slowly" if "speed" in fault.concerns else "go less far"
    return Finding(name, False, fault.reason, fix)


def _distance(up: str | None, down: str | None) -> float:
    """Return how far the hand is to go, m, below 0 for down."""
    if (up is None) == (down is None):
        raise InvalidInput("name one of --up and --down, as in --up 10mm; nothing was moved")
    by = quantity_of("--up", "Length", up) if up is not None else quantity_of("--down", "Length", str(down))
    if by <= 0:
        raise InvalidInput("the distance is more than 0 mm, as in --up 10mm; nothing was moved")
    return by if up is not None else -by
