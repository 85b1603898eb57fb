"""`stretch-bt doctor`."""

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
    """Look at every device of a cell from its network to a first second of readings, and say what to do; moves nothing."""
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.hardware.examine import doctor

    spec = load_cell(cell)
    if device is not None and device not in spec.devices:
        raise InvalidInput(f"the cell has no device {device!r}; {did_you_mean(device, spec.devices)}")
    if not print_findings(doctor(spec, device), json_):
        raise typer.Exit(EXIT_FAULT)
