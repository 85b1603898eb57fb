"""`stretch-bt stop`."""

from __future__ import annotations

from stretch_bt.cli.looking import Cell, Device, look
from stretch_bt.cli.output import AsJson

__all__ = ["command"]


def command(cell: Cell, device: Device = None, json_: AsJson = False) -> None:
    """Stop every device of a cell that moves, and our control script on the controller, beside a run too; says what it found."""
    from stretch_bt.hardware.examine import halt

    look(halt, cell, device, as_json=json_)
