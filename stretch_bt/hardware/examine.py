"""Looking at the devices of a cell, without moving anything: in short for its status, at length for a doctor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from typing import Any, TypeVar

from stretch_bt.blame import place_of
from stretch_bt.errors import DeviceLost, InvalidInput, NotReady, StretchError, named
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.cell_file import CellSpec, DeviceSpec
from stretch_bt.hardware.checked_reading import check_reading
from stretch_bt.hardware.claim import Claim
from stretch_bt.hardware.driver import (
    ArmDriver,
    CellContext,
    DepthCameraDriver,
    Driver,
    ForceSensorDriver,
    GripperDriver,
)
from stretch_bt.hardware.finding import Finding
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Reading

__all__ = ["AS_IT_SAYS", "doctor", "halt", "status"]

V = TypeVar("V")

_LOOKING = 1.0
_PAUSE = 0.002
#: readings further apart than this, s, are too few for a run
_SPARSE = 0.25
#: what to do about a fault of a device
AS_IT_SAYS = "do what the fault says; docs/devices.md leads to the page of each shipped device, docs/drivers.md says how to write one"
#: an older one, s, is none of a device that answers
_OLD = 2.0
#: how far a device that stands may seem to go, m; how long one takes to stand, and a run that was stopped to let go of it, s
_STANDS, _BRAKING, _LETTING_GO = 3e-4, 0.2, 2.0
_ENDS = "press the emergency stop where it moves; Ctrl-C ends the run that has it"


def status(spec: CellSpec, only: str | None = None) -> Iterator[Finding]:
    """Yield one finding for each device: what it says now, read only."""
    for device, driver in _drivers(spec, only):
        if not isinstance(driver, Driver):
            yield driver
        else:
            yield _seen(device, driver)


def doctor(spec: CellSpec, only: str | None = None) -> Iterator[Finding]:
    """Yield what a look at everything finds, device by device; makes ready to move what can be, and moves nothing."""
    yield Finding("cell", True, f"{spec.path.name}: {len(spec.devices)} devices")
    for device, driver in _drivers(spec, only):
        if not isinstance(driver, Driver):
            yield driver
            continue
        lacking = [name for name in driver.packages if find_spec(name) is None]
        if lacking:
            fix = f"pip install {' '.join(driver.packages[name] for name in lacking)}"
            yield Finding(f"{device.name}: packages", False, f"not installed: {', '.join(lacking)}", fix)
            continue
        yield from _findings(device, driver)
        seen = _seen(device, driver, over=_LOOKING)
        yield seen
        if seen.ok:
            yield _ready(device, driver)


def halt(spec: CellSpec, only: str | None = None) -> Iterator[Finding]:
    """Stop every device that moves, arms first and beside a run too, and yield what was found of each device."""
    for device, driver in sorted(_drivers(spec, only), key=lambda pair: pair[0].type != "Arm"):
        if not isinstance(driver, Driver):
            yield driver
        elif isinstance(driver, ArmDriver | GripperDriver):
            yield device.options.halt(device.name) or _held(device, driver)
        else:
            yield Finding(device.name, True, "nothing of it moves")


def _drivers(spec: CellSpec, only: str | None) -> Iterator[tuple[DeviceSpec, Driver | Finding]]:
    """Yield each device with its driver, or with a finding where there is no driver to look at."""
    cell = CellContext(time.monotonic, 0, spec.path.parent, Hand(spec.hand), spec.limits)
    for device in spec.devices.values():
        if only in (None, device.name):
            yield device, _made(device, cell) if device.implementation.real else _simulated(device)


def _made(device: DeviceSpec, cell: CellContext) -> Driver | Finding:
    try:
        return device.driver(cell)
    except StretchError as error:
        return Finding(device.name, False, str(error), "mend the driver, or ask who wrote it")


def _findings(device: DeviceSpec, driver: Driver) -> Iterator[Finding]:
    """Yield what a driver finds, and what broke in that."""
    try:
        yield from driver.findings()
    except Exception as error:
        yield Finding(f"{device.name}: findings", False, _said(error), "mend the driver, or ask who wrote it")


def _simulated(device: DeviceSpec) -> Finding:
    return Finding(device.name, True, f"{device.use}: there is nothing to connect to")


def _seen(device: DeviceSpec, driver: Driver, over: float = 0.0) -> Finding:
    """Return what a device says of itself, read for a time, s."""
    check = device.name if not over else f"{device.name}: reading"
    try:
        driver.open_to_read()
        try:
            return Finding(check, *_read(driver, over))
        finally:
            driver.close()
    except Exception as error:  # also what the client of a driver raises
        return Finding(check, False, _said(error), AS_IT_SAYS)


def _held(device: DeviceSpec, driver: ArmDriver | GripperDriver) -> Finding:
    """Return whether a device stands once its driver has stopped it."""
    try:
        _open_soon(driver)
        try:
            driver.hold()
            moved = _moved(driver)
            detail = f"it still moves; {moved}" if moved else f"it holds where it is; {_read(driver, 0.0)[1]}"
            return Finding(device.name, not moved, detail, _ENDS if moved else "")
        finally:
            driver.close()
    except Exception as error:
        return Finding(device.name, False, _said(error), _ending(device, driver))


def _ending(device: DeviceSpec, driver: Driver) -> str:
    """Return how to stop a device that is not to be had: a program that has it, as on a serial line, is named."""
    try:
        with Claim(device.name, driver.claimed()):
            return _ENDS
    except NotReady as had:
        return f"{_ENDS}: {had.reason}"


def _said(error: Exception) -> str:
    """Return what an error says; the driver broke that raised one of another package."""
    if isinstance(error, StretchError | OSError) and not isinstance(error, InvalidInput):
        return str(error)
    at = place_of(error)
    return f"its driver broke ({named(error)}){at and f' at {at}'}"


def _open_soon(driver: Driver) -> None:
    """Open a device, which a run that ends has to let go of first; raises NotReady or DeviceLost where it does not do that soon."""
    due = time.monotonic() + _LETTING_GO
    while True:
        try:
            return driver.open()
        except (NotReady, DeviceLost):  # a serial line that another program has is lost
            if time.monotonic() > due:
                raise
            time.sleep(_PAUSE)


def _moved(driver: ArmDriver | GripperDriver) -> str:
    """Return how far a device still goes after a command to stop, or nothing: a run beside may lead it on."""
    read, _ = _reading(driver)
    time.sleep(_BRAKING)
    before = read().value
    time.sleep(_LOOKING)
    after = read().value
    way = math.dist(before[0].position, after[0].position) if isinstance(driver, ArmDriver) else abs(after - before)
    return f"{1e3 * way:.1f} mm in {_LOOKING:g} s" if way > _STANDS else ""


def _ready(device: DeviceSpec, driver: Driver) -> Finding:
    check = f"{device.name}: ready"
    try:
        with Claim(device.name, driver.claimed()):
            try:
                driver.open()
                reason = driver.unready()
            finally:
                driver.close()
    except Exception as error:  # also what the client of a driver raises
        return Finding(check, False, _said(error), AS_IT_SAYS)
    return Finding(check, reason is None, reason or "it takes commands", "" if reason is None else "do what it says")


def _read(driver: Driver, over: float) -> tuple[bool, str]:
    """Return whether readings come often enough, and what the latest one says."""
    read, say = _reading(driver)
    first = latest = read()
    end, begun = time.monotonic() + over, time.monotonic()
    count, longest, seen = 0, 0.0, begun
    while (now := time.monotonic()) < end:
        latest = read()
        if latest.sequence != first.sequence:
            first, count, longest, seen = latest, count + 1, max(longest, now - seen), now
        time.sleep(_PAUSE)
    age = driver.cell.now() - latest.host_time
    if age > _OLD:
        return False, f"{say(latest.value)}; that was {age:.1f} s ago, older than nodes take"
    if not over:
        return True, say(latest.value)
    longest = max(longest, time.monotonic() - seen)
    detail = f"{say(latest.value)}; {count / over:.0f} readings/s, at most {1e3 * longest:.0f} ms apart"
    return longest < _SPARSE, detail


def _opened(driver: GripperDriver, opening: float) -> str:
    """Say where the fingers stand, with the gripper's own number of it, which its calibration needs."""
    count = driver.count()
    return f"opening {1e3 * opening:.1f} mm" + ("" if count is None else f", count {count}")


def _reading(driver: Driver) -> tuple[Callable[[], Reading[Any]], Callable[[Any], str]]:
    """Return what to read of a driver, and how to say it."""
    if isinstance(driver, ArmDriver):
        return lambda: _pair(driver), lambda both: f"{_place(both[0])}; {_force(both[1])}"
    if isinstance(driver, GripperDriver):
        return lambda: _sure(driver, "opening", driver.opening()), lambda opening: _opened(driver, opening)
    if isinstance(driver, DepthCameraDriver):
        return lambda: _sure(
            driver, "frame", driver.frame()
        ), lambda frame: f"frames of {frame.raw.shape[1]} x {frame.raw.shape[0]}"
    assert isinstance(driver, ForceSensorDriver)
    return lambda: _sure(driver, "wrench", driver.wrench()), _force


def _sure(driver: Driver, name: str, reading: Reading[V]) -> Reading[V]:
    """Return a reading that a run would take, but for its age."""
    check_reading(name, reading, driver.cell.now())
    return reading


def _pair(driver: ArmDriver) -> Reading[tuple[Pose, Wrench]]:
    pose, wrench = _sure(driver, "pose", driver.pose()), _sure(driver, "wrench", driver.wrench())
    return Reading((pose.value, wrench.value), pose.device_time, pose.host_time, pose.sequence)


def _place(pose: Pose) -> str:
    x, y, z = (round(1e3 * v, 1) + 0.0 for v in pose.position)  # no -0.0
    turned = math.degrees(math.hypot(*pose.rotation))
    return f"hand at {x:.1f}, {y:.1f}, {z:.1f} mm, turned by {turned:.1f} deg"


def _force(wrench: Wrench) -> str:
    x, y, z = (round(v, 2) + 0.0 for v in wrench.force)  # no -0.0
    return f"force {wrench.magnitude:.2f} N ({x:.2f}, {y:.2f}, {z:.2f})"
