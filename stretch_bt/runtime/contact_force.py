"""How hard a motion may meet something before the arm stands, held against what a cell allows before anything moves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from stretch_bt.errors import Diagnostic
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.peak_force import Stopping, fastest_for, peak_force
from stretch_bt.quantity_text import format_quantity
from stretch_bt.source import Mark
from stretch_bt.units import KINDS

__all__ = ["hard_contact"]

_FORCE, _SPEED, _STIFFNESS = KINDS["Force"], KINDS["Speed"], KINDS["Stiffness"]


def hard_contact(
    spec: CellSpec, devices: Sequence[str], where: str, limit: str, speed: float, mark: Mark
) -> Iterator[Diagnostic]:
    """Yield that something which a motion meets may feel more than the cell allows.

    Parameters
    ----------
    spec
        The cell.
    devices
        Names of the devices of the node that moves the arm, as the cell has them.
    where
        The port of its speed, for the message.
    limit
        The limit of that port. A motion whose port has `speed` meets something only below the height that the cell names for that, and
        goes no faster there than the cell allows.
    speed
        The highest that the port can have, m/s.
    mark
        Where that is written.
    """
    stopping, limits = _stopping(spec, devices), spec.limits
    if stopping is None or (limit != "contact_speed" and limits.contact is not None):
        return
    found = peak_force(speed, limits.stiffness, limits.force, stopping)
    if found.stopped <= limits.peak_force:
        return
    stiffness, peak = format_quantity(limits.stiffness, _STIFFNESS), format_quantity(limits.peak_force, _FORCE)
    message = (
        f"{where}: at {format_quantity(speed, _SPEED)} and {stiffness} a contact force rises to {found.stopped:.0f} N before the arm "
        f"stands, and to {found.late:.0f} N where the connection fails meanwhile; the arm begins to stop at "
        f"{format_quantity(limits.force, _FORCE)}, and {spec.path.name} allows peaks of {peak}"
    )
    yield mark.warning("cell-force", message, _remedy(spec, stopping, speed))


def _stopping(spec: CellSpec, devices: Sequence[str]) -> Stopping | None:
    """Return how the arm that a node uses stops; None without one, or where the arm is not real."""
    for name in devices:
        device = spec.devices.get(name)
        if device is not None and (found := device.options.stopping(spec.limits)) is not None:
            return found
    return None


def _remedy(spec: CellSpec, stopping: Stopping, speed: float) -> str:
    limits = spec.limits
    fast = fastest_for(limits.peak_force, limits.stiffness, limits.force, stopping, speed)
    if fast is None:
        return "lower 'limits: {force: ...}', which is above the peak that is allowed"
    step = 10.0 ** (math.floor(math.log10(1e3 * fast)) - 1)
    slow = f"use at most {math.floor(1e3 * fast / step) * step:.2g} mm/s"  # two digits, and no more than it is
    return f"{slow}, or write 'limits: {{stiffness: ...}}' where hand and object are softer than that"
