"""A cell of somebody's own, on which the contract is tested where its file is named: nothing moves that is not named too."""

import os

import pytest

from stretch_bt.errors import CellError
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.testing import device_contract
from stretch_bt.testing.contract.trial import READINGS

#: a cell file; names of the devices in it that may move, with spaces between them
CELL, MOVE = "STRETCH_BT_CELL", "STRETCH_BT_MOVE"
#: the hand goes up, and the fingers open, by this, m, at this speed, m/s
WAY, SPEED = 0.015, 0.015
#: how far a device may be from where the first test found it to be led back there, m
_ASTRAY = 0.03
#: of a motion, m, of a force after `zero()`, N, and of a reading, s
TOLERANCE, FORCE, LATENCY = 0.006, 1.0, 0.5
_MOVERS = ("Arm", "Gripper")
_homes = {}


def contracts():
    """Return the contracts of the devices of the cell that is named, by the names of their classes; none where none is."""
    path = os.environ.get(CELL)
    if path is None or "PYTEST_XDIST_WORKER" in os.environ:  # the devices of a cell are one process's at a time
        return {}
    try:
        types = {name: device.type for name, device in load_cell(path).devices.items() if device.type in READINGS}
    except CellError as error:
        raise pytest.UsageError(f"{CELL}: {error}") from None
    allowed, able = os.environ.get(MOVE, "").split(), [name for name, type_ in types.items() if type_ in _MOVERS]
    if unknown := set(allowed) - set(able):
        raise pytest.UsageError(
            f"{MOVE}: {path} has nothing that moves named {', '.join(sorted(unknown))}; write names of {able}, with spaces between them"
        )
    return {f"TestHardware_{name}": _contract(path, name, type_, allowed) for name, type_ in types.items()}


def _contract(path, name, type_, allowed):
    moves = _moves(name) if name in allowed else None
    tolerance = FORCE if type_ == "ForceSensor" else TOLERANCE
    return device_contract(path, name, moves=moves, tolerance=tolerance, latency=LATENCY, speed=SPEED)


def _moves(name):
    """Return a function that gives where a device stood in the first test, and a place a little further."""

    def moves(device):
        here = (device.pose(1.0) if hasattr(device, "pose") else device.opening(1.0)).value
        home = _homes.setdefault(name, _allowed(device, here))
        away = (
            max(abs(a - b) for a, b in zip(here.position, home.position, strict=True))
            if isinstance(home, Pose)
            else abs(here - home)
        )
        assert away < _ASTRAY, f"{name} is {1e3 * away:.0f} mm from where it was at first; bring it back by hand"
        return home, home.at_height(home.height + WAY) if isinstance(home, Pose) else home + WAY

    return moves


def _allowed(device, here):
    """Return a place to come back to: fingers may stand a count outside of the limits."""
    if isinstance(here, Pose):
        return here
    geometry, (least, most) = device.watch.hand.geometry, device.watch.limits.span("stretch")
    return geometry.opening(min(max(geometry.stretch(here), least), most))
