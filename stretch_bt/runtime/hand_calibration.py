"""Finding where the camera stands in the hand, and which count of the gripper is which opening, by looking at the free membrane."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stretch_bt import perception
from stretch_bt.clock import Clock
from stretch_bt.errors import DeviceFault, IllConditioned, InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.hardware.ages import FRAME, PLACE
from stretch_bt.hardware.cell import Cell
from stretch_bt.hardware.cell_file import CellSpec
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.perception.hand_eye import HandView, OutOfView, view_of_hand
from stretch_bt.runtime.pending_finally import raise_besides
from stretch_bt.runtime.signals import unbroken
from stretch_bt.units import Estimate

__all__ = ["HandCalibration", "Stop", "calibrate_hand", "hand_devices"]

_TICK = 0.02
#: of the fingers, m/s
_SPEED = 0.020
#: how long frames and a motion may take, s
_PATIENCE = 60.0
#: standard deviation of where in a count the fingers stand
_COUNT = 1 / math.sqrt(12)
#: largest root mean square of the lengths' distances from a line over the openings, m; it is 0.03 to 0.3 mm where the ends are seen
_BENT = 2e-3
#: standard deviations that the camera's place at a stop may be off its mean
_MOVED = 6.0
#: parts of the camera's pose, all of which are the same at every stop
_POSE = ("x", "y", "distance", "tilt_x", "tilt_y", "yaw", "aim_x", "aim_y")


_UNSEEN = "its ends or sides are not seen for what they are: free the view of all of the membrane, or move the camera away from it"


@dataclass(frozen=True, slots=True)
class Stop:
    """An opening at which the membrane was looked at: as the gripper reports it, m, its own count, if it has one, and the view."""

    told: float
    count: int | None
    view: HandView


@dataclass(frozen=True, slots=True)
class HandCalibration:
    """The camera in the hand, m and rad; `ratio` of the openings that were seen to the reported openings; counts and their openings, m.

    `residual` is the root mean square distance of the membrane's lengths from a line over the openings, m.
    """

    camera: dict[str, Estimate]
    ratio: Estimate
    points: tuple[tuple[int, Estimate], ...]
    residual: float
    stops: tuple[Stop, ...]


def hand_devices(spec: CellSpec) -> tuple[str, str]:
    """Return the names of the gripper and the camera of a cell; raises InvalidInput where it has none or several."""
    gripper, camera = (_only(spec, kind) for kind in ("Gripper", "DepthCamera"))
    return gripper, camera


def calibrate_hand(
    cell: Cell,
    clock: Clock,
    *,
    stops: int = 6,
    frames: int = 16,
    said: Callable[[str], None] = lambda text: None,
) -> HandCalibration:
    """Stretch the free membrane in steps within the limits of the cell, look at it at each, and go back to the first.

    The fingers go at 20 mm/s, or as fast as the cell allows where that is less.

    Only the gripper moves. Where the membrane's ends leave the view the steps end.

    Raises
    ------
    DeviceFault
        A device fails, or the fingers do not get where they are sent; everything that moves is stopped.
    IllConditioned
        Too little of the membrane is seen, or it touches something.
    InvalidInput
        The cell has not one gripper and one camera.
    """
    devices: Mapping[str, Any] = cell.devices
    gripper, camera = (devices[name] for name in hand_devices(cell.spec))
    span, speed = cell.spec.span("stretch"), min(_SPEED, cell.spec.limits.gripper_speed)
    geometry, found, raised = cell.hand.geometry, list[Stop](), list[BaseException]()
    try:
        for stretch in np.linspace(max(span[0], 0.0), span[1], stops):
            _go(gripper, geometry.opening(float(stretch)), speed, clock)
            told, count = gripper.opening(PLACE).value, gripper.driver.count()
            frame = _look(camera, frames, clock)
            try:
                view = view_of_hand(frame, geometry.plane_distance)
            except OutOfView as refused:
                if len(found) < 2:
                    raise
                said(f"stretch {1e3 * stretch:.1f} mm: {refused.reason}; the stops end here")
                break
            found.append(Stop(told, count, view))
            said(f"stretch {1e3 * stretch:.1f} mm: the membrane is {1e3 * view.length:.2f} mm long")
        _go(gripper, geometry.opening(max(span[0], 0.0)), speed, clock)
    except BaseException as error:
        raised.append(error)
        raise
    finally:
        with unbroken() as errors:
            errors += cell.stop()
        raise_besides(raised, errors)  # such as that the fingers may go on
    return _fitted(found, geometry.opening(0.0), span)


def _fitted(found: list[Stop], rest: float, span: tuple[float, float]) -> HandCalibration:
    """Put the stops together: the camera's errors are the same at each, the errors of the ends are not."""
    camera = {}
    for name in _POSE:
        estimates = [getattr(stop.view, name) for stop in found]
        camera[name] = Estimate(float(np.mean(estimates)), float(np.mean([e.sd for e in estimates])))
        if any(abs(e - camera[name]) > _MOVED * e.sd for e in estimates):
            raise IllConditioned(f"the camera seems to stand elsewhere at each stop, by its {name}; {_UNSEEN}")
    lengths = np.array([float(stop.view.length) for stop in found])
    sds = np.array([stop.view.length.sd for stop in found])
    scale = camera["distance"].sd / camera["distance"]
    told = np.array([stop.told for stop in found])
    ratio, ratio_sd, residual = _slope(told, lengths, sds)
    counts = [stop.count for stop in found if stop.count is not None]
    points: tuple[tuple[int, Estimate], ...] = ()
    if len(counts) == len(found):
        slope, slope_sd, residual = _slope(np.array(counts, float), lengths, sds)
        # where the membrane is as long as it was mounted the opening is `rest_opening`, by the present calibration
        start, sd = float(told[0]), math.hypot(slope_sd, slope * scale)
        for count in sorted({min(max(round(counts[0] + (rest + s - start) / slope), 0), 255) for s in span}):
            way = count - counts[0]
            points += ((count, Estimate(start + slope * way, math.hypot(sd * way, _COUNT * slope))),)
    return HandCalibration(camera, Estimate(ratio, math.hypot(ratio_sd, scale)), points, residual, tuple(found))


def _slope(x: Any, y: Any, sds: Any) -> tuple[float, float, float]:
    """Return the slope of a line, its standard deviation, and the root mean square of what is left, m."""
    if len(x) < 3 or np.ptp(x) <= 0:
        raise IllConditioned(
            "the membrane was seen at fewer than three openings; widen the view or the limits of stretch, or look at more stops"
        )
    slope, level = np.polyfit(x, y, 1)
    rest = y - level - slope * x
    left = float(np.sqrt(np.mean(rest**2)))
    if left > _BENT:
        told = ", ".join(f"{1e3 * length:.1f}" for length in y)
        raise IllConditioned(
            f"the membrane is {told} mm long at its stops, which is no line over the openings; {_UNSEEN}"
        )
    spread = float(np.sqrt(np.sum((x - x.mean()) ** 2)))
    return float(slope), max(float(sds.mean()), left * math.sqrt(len(x) / (len(x) - 2))) / spread, left


def _only(spec: CellSpec, kind: str) -> str:
    names = [name for name, device in spec.devices.items() if device.type == kind]
    if len(names) != 1:
        raise InvalidInput(f"the hand is calibrated with one {kind}, and the cell has {len(names)}")
    return names[0]


def _go(gripper: Any, opening: float, speed: float, clock: Clock) -> None:
    """Move the fingers, and wait until they are there."""
    motion = gripper.move(opening, speed=speed, owner="calibrate-hand")
    due = clock.now() + _PATIENCE
    while (state := motion.poll()) is MotionState.MOVING:
        if clock.now() > due:
            raise DeviceFault(gripper.name, f"the fingers did not arrive within {_PATIENCE:.0f} s")
        clock.wait_until(clock.now() + _TICK)
    if state is not MotionState.DONE:
        raise DeviceFault(gripper.name, f"the fingers did not get to {1e3 * opening:.1f} mm: {state}")


def _look(camera: Any, count: int, clock: Clock) -> DepthFrame:
    """Return the mean of frames that are exposed from now on."""
    since, due = clock.now(), clock.now() + _PATIENCE
    found: dict[int, DepthFrame] = {}
    while len(found) < count:
        if clock.now() > due:
            raise DeviceFault(camera.name, f"{len(found)} of {count} frames came within {_PATIENCE:.0f} s")
        reading = camera.frame(FRAME)
        if reading.host_time > since:
            found[reading.sequence] = reading.value
        clock.wait_until(clock.now() + _TICK)
    return perception.average_frames(list(found.values()))
