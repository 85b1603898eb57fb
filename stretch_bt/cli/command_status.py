"""`stretch-bt status`."""

from __future__ import annotations

from stretch_bt.cli.looking import Cell, Device, look
from stretch_bt.cli.output import AsJson

__all__ = ["command"]


def command(cell: Cell, device: Device = None, json_: AsJson = False) -> None:
    """Say how each device of a cell stands now; reads only, and needs no part of a device that somebody else uses."""
    from stretch_bt.hardware.examine import status

    look(status, cell, device, as_json=json_)
