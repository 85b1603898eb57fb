"""`stretch-bt doctor`."""

from __future__ import annotations

from stretch_bt.cli.looking import Cell, Device, look
from stretch_bt.cli.output import AsJson

__all__ = ["command"]


def command(cell: Cell, device: Device = None, json_: AsJson = False) -> None:
    """Look at every device of a cell from its network to a first second of readings, and say what to do; moves nothing."""
    from stretch_bt.hardware.examine import doctor

    look(doctor, cell, device, as_json=json_)
