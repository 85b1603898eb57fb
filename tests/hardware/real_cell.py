"""A cell of somebody's own, on which the contract is tested where its file is named: nothing moves that is not named too."""

import os
import time

import pytest

from stretch_bt.errors import CellError
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import MotionState

#: a cell file; names of those of its devices that may move, with spaces between them
CELL, MOVE = "STRETCH_BT_CELL", "STRETCH_BT_MOVE"
#: what the contract calls 50 mm is so much of that: the hand goes up, and the fingers open, by 15 mm at most; m/s
SCALE, SPEED = 0.2, 0.015
#: how far a device may be from where the first test found it to be led back there, m
_ASTRAY = 0.03
_READINGS = {"Arm": ("pose", "wrench"), "Gripper": ("opening",), "DepthCamera": ("frame",), "ForceSensor": ("wrench",)}
_MOVERS = ("Arm", "Gripper")
_homes = {}


def _skipped(width, why):
    return [pytest.param(*["hardware"] * width, marks=pytest.mark.skip(reason=why))]


def rows():
    """Return what is tested, for the tables of the contract: readers, movers, devices; what is not asked for is skipped."""
    path = os.environ.get(CELL)
    if path is None:
        why = f"no hardware: name a cell file in {CELL}, and the devices that may move in {MOVE}"
        return _skipped(3, why), _skipped(2, why), _skipped(2, why)
    if "PYTEST_XDIST_WORKER" in os.environ:
        why = "the devices of a cell are one process's at a time: run this file alone, without -n"
        return _skipped(3, why), _skipped(2, why), _skipped(2, why)
    try:
        types = {name: device.type for name, device in load_cell(path).devices.items() if device.type in _READINGS}
    except CellError as error:
        raise pytest.UsageError(f"{CELL}: {error}") from None
    allowed, able = os.environ.get(MOVE, "").split(), [name for name, type_ in types.items() if type_ in _MOVERS]
    if unknown := set(allowed) - set(able):
        raise pytest.UsageError(
            f"{MOVE}: {path} has nothing that moves named {', '.join(sorted(unknown))}; write names of {able}, with spaces between them"
        )
    movers = [("hardware", name) for name in allowed]
    readers = [("hardware", name, reading) for name, type_ in types.items() for reading in _READINGS[type_]]
    return readers, movers or _skipped(2, f"nothing may move: name devices in {MOVE}"), [("hardware", n) for n in types]


def bring_home(cell):
    """Note where a device that may move stands in the first test, and bring it back there in all others."""
    cell.homes = {}
    for name in os.environ.get(MOVE, "").split():
        if name in cell.devices:
            device = cell.devices[name]
            home = _homes.setdefault(name, _allowed(cell, _stands(device)))
            away = _away(device, home)
            assert away < _ASTRAY, f"{name} is {1e3 * away:.0f} mm from where it was at first; bring it back by hand"
            if away > 1e-3:
                motion = device.move(home, speed=SPEED, owner="home")
                while (state := motion.poll()) is MotionState.MOVING:
                    time.sleep(0.02)
                assert state is MotionState.DONE
            cell.homes[name] = _stands(device)


def target(cell, name, way):
    """Return where a device is so far, m, on the way that it may go."""
    home = cell.homes[name]
    return home.at_height(home.height + SCALE * way) if isinstance(home, Pose) else home + SCALE * way


def gone(cell, name):
    """Return how far it is on that way, m."""
    home, here = cell.homes[name], _stands(cell.devices[name])
    return ((here.height - home.height) if isinstance(home, Pose) else here - home) / SCALE


def _allowed(cell, home):
    """Return a place to come back to: fingers may stand a count outside of the limits."""
    if isinstance(home, Pose):
        return home
    geometry, (least, most) = cell.hand.geometry, cell.spec.limits.span("stretch")
    return geometry.opening(min(max(geometry.stretch(home), least), most))


def _stands(device):
    return (device.pose(1.0) if hasattr(device, "pose") else device.opening(1.0)).value


def _away(device, home):
    here = _stands(device)
    return (
        max(abs(a - b) for a, b in zip(here.position, home.position, strict=True))
        if isinstance(home, Pose)
        else abs(here - home)
    )
