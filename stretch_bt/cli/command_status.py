"""`stretch-bt status`."""

from __future__ import annotations

from typing import Annotated

import typer

from stretch_bt.cli.output import EXIT_FAULT, print_findings
from stretch_bt.errors import InvalidInput
from stretch_bt.source import did_you_mean

__all__ = ["command"]


def command(
    cell: Annotated[str, typer.Argument(help="A cell file, or the name of a shipped cell.")],
    device: Annotated[str | None, typer.Option("--device", help="Only this one.")] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Say how each device of a cell stands now; reads only, and needs no part of a device that somebody else uses."""
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.hardware.examine import status

    spec = load_cell(cell)
    if device is not None and device not in spec.devices:
        raise InvalidInput(f"the cell has no device {device!r}; {did_you_mean(device, spec.devices)}")
    if not print_findings(status(spec, device), json_):
        raise typer.Exit(EXIT_FAULT)
