"""What the commands that look at the devices of a cell share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from stretch_bt.cli.output import EXIT_FAULT, AsJson, print_findings
from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean

if TYPE_CHECKING:
    from stretch_bt.hardware.cell_file import CellSpec
    from stretch_bt.hardware.finding import Finding

__all__ = ["SCENE", "AsJson", "Cell", "Device", "look"]

SCENE = "water_balloon"  # of a simulated cell, where none is named

Cell = Annotated[str, typer.Argument(help="A cell file, or the name of a shipped cell.")]
Device = Annotated[str | None, typer.Option("--device", help="Only this one.")]


def look(
    way: Callable[[CellSpec, str | None], Iterable[Finding]], cell: str, device: str | None, *, as_json: bool
) -> None:
    """Look at a cell, or at one of its devices, in one way, and print what was found; exits with a fault where something was wrong."""
    from stretch_bt.hardware.cell_file import load_cell

    spec = load_cell(cell)
    if device is not None and device not in spec.devices:
        raise InvalidInput(f"the cell has no device {device!r}; {did_you_mean(device, spec.devices)}")
    if not print_findings(way(spec, device), as_json):
        raise typer.Exit(EXIT_FAULT)
