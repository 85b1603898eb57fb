"""Whether anything of a cell can hold the limit of force of a motion, before anything moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stretch_bt.errors import Diagnostic
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.least_force import least_limit
from stretch_bt.quantity_text import format_quantity
from stretch_bt.source import Mark
from stretch_bt.units import KINDS

__all__ = ["HELD", "unheld_force"]

#: limits of ports at which a motion stops
HELD = ("held_force", "lowered_force")


def unheld_force(spec: CellSpec, devices: Sequence[str], where: str, limit: float, mark: Mark) -> Iterator[Diagnostic]:
    """Yield that the arm's force is too noisy to hold a limit, N, where no force sensor of the cell holds it.

    Parameters
    ----------
    spec
        The cell.
    devices
        Names of the devices of the node that moves the arm, as the cell has them.
    where
        The port of the limit, for the message.
    limit
        N.
    mark
        Where that is written.
    """
    used = [spec.devices[name] for name in devices if name in spec.devices]
    if any(device.type == "ForceSensor" for device in used):
        return
    for device in used:
        least = least_limit(device.options.force_noise())
        if limit < least:
            force = KINDS["Force"]
            message = (
                f"{where} is {format_quantity(limit, force)}; the force of {device.name!r} is too noisy to hold less than "
                f"{least:.2g} N, and no force sensor holds it"
            )
            yield mark.error(
                "cell-limit", message, "declare a force sensor in the tree and the cell, or allow more force"
            )
