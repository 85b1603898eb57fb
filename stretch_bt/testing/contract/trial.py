"""One device under test: its simulator, its cell, and the clock that it goes by."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest

from stretch_bt.clock import VirtualClock
from stretch_bt.errors import DeviceFault, InvalidInput
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import Cell, open_cell
from stretch_bt.hardware.cell_file import CellSpec, load_cell
from stretch_bt.hardware.driver import CellContext, Driver
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import Motion, MotionState, Reading
from stretch_bt.simulation.scene import load_scene
from stretch_bt.testing.contract.simulator import brought_up, call_with

__all__ = ["READINGS", "Contract", "Trial", "fault"]

#: readings that each kind of device has
READINGS = {"Arm": ("pose", "wrench"), "Gripper": ("opening",), "DepthCamera": ("frame",), "ForceSensor": ("wrench",)}
#: old readings are tested by the clauses, so none is refused before, s
_ANY_AGE = 1e6
_SCENE = "water_balloon"
_STEP = 0.01
#: longest time that a motion of the contract may take, s
_LONGEST = 60.0
_SPEED = 0.05


def fault(text: str) -> NoReturn:
    """Fail a test by what is wrong with the device, in words and without a traceback into the suite."""
    pytest.fail(text, pytrace=False)


@dataclass(frozen=True)
class Contract:
    """The arguments of `device_contract`."""

    cell: Any
    device: str
    start: Callable[[], Any] | None
    moves: Sequence[Any] | Callable[[Any], Sequence[Any]] | None
    tolerance: float
    latency: float
    cut: Callable[..., Any] | None
    speed: float | None
    scene: str | Path | None
    load: Callable[..., Any] | None = None
    #: kind of the device for which the clauses are; None where any may be
    kind: str | None = None
    #: readings for the clauses on readings
    looked: dict[str, list[Any]] = field(default_factory=dict)

    @contextmanager
    def simulator(self) -> Iterator[tuple[Any, CellSpec]]:
        """Bring up what stands in for the device, and give it with the cell file."""
        with brought_up(self.start) as made:
            yield made, load_cell(self.cell(made) if callable(self.cell) else self.cell)

    @contextmanager
    def trial(self) -> Iterator[Trial]:
        """Bring up the simulator, and close every cell at the end."""
        with ExitStack() as stack:
            trial = Trial(self, *stack.enter_context(self.simulator()), stack)
            stack.callback(trial.close)
            yield trial


class Trial:
    """A device that a clause opens, reads, moves and cuts off; `brought_up` ends what was brought up for it."""

    def __init__(self, contract: Contract, simulator: Any, spec: CellSpec, brought_up: ExitStack) -> None:
        if contract.device not in spec.devices:
            raise InvalidInput(f"the cell has no device {contract.device!r}, but {', '.join(spec.devices)}")
        self.contract, self.simulator, self.spec = contract, simulator, spec
        self.kind = spec.devices[contract.device].type
        if contract.kind not in (None, self.kind):
            raise InvalidInput(f"{contract.device!r} is a {self.kind}, not a {contract.kind}; write kind={self.kind!r}")
        #: twins and recordings go by a clock that the test moves, all else by the machine's clock
        self.virtual = None if spec.devices[contract.device].implementation.real else VirtualClock()
        self.now: Callable[[], float] = time.monotonic if self.virtual is None else self.virtual.now
        #: places between which it is moved, once it was opened
        self.moves: Sequence[Any] = ()
        self._cells: list[Cell] = []
        self._brought_up = brought_up
        self._scene = load_scene(contract.scene or _SCENE) if spec.simulated else None

    @property
    def readings(self) -> tuple[str, ...]:
        """Names of what can be read."""
        return READINGS[self.kind]

    @property
    def speed(self) -> float:
        """Speed of the motions, m/s: as given, else one that the limits of the cell allow."""
        limits = self.spec.limits
        return self.contract.speed or min(_SPEED, limits.gripper_speed if self.kind == "Gripper" else limits.speed)

    def leave(self) -> None:
        """Close every cell, and end the simulator."""
        self._brought_up.close()

    def driver(self) -> Driver:
        """Return a driver that nothing opened."""
        spec = self.spec
        return spec.devices[self.contract.device].driver(
            CellContext(self.now, 0, spec.path.parent, Hand(spec.hand), spec.limits, self._scene)
        )

    def open(self) -> Any:
        """Open the device, and return it as nodes see it."""
        try:
            cell = open_cell(self.spec, now=self.now, scene=self._scene, only=[self.contract.device])
        except DeviceFault as error:
            fault(f"it does not open: {error.reason}")
        self._cells.append(cell)
        device, moves = cell.devices[self.contract.device], self.contract.moves
        if moves is not None and not self.moves:
            self.moves = tuple(moves(device) if callable(moves) else moves)
        return device

    def close(self) -> None:
        """Close every cell that was opened."""
        for cell in self._cells:
            with suppress(Exception):  # a clause has reported the mistake
                cell.close()

    def wait(self, duration: float) -> None:
        """Let time pass, s."""
        if self.virtual is None:
            time.sleep(duration)
        else:
            self.virtual.advance(duration)

    def ticks(self, duration: float) -> Iterator[float]:
        """Yield the time, s, since the first one, again and again for a duration."""
        begun = self.now()
        while (passed := self.now() - begun) < duration:
            yield passed
            self.wait(_STEP)

    def read(self, device: Any, name: str) -> Reading[Any]:
        """Return a reading, however old."""
        reading: Reading[Any] = getattr(device, name)(_ANY_AGE)
        return reading

    def over(self, device: Any) -> bool:
        """Return whether what is played has come to its end."""
        return bool(device.driver.ended)

    def place(self, device: Any) -> Any:
        """Return where a device that moves says it is: an opening, m, or a pose."""
        return self.read(device, self.readings[0]).value

    def move(self, device: Any, target: Any, speed: float | None = None, owner: str = "contract") -> Motion:
        """Begin a motion, at another speed, m/s, than the usual one where it is given."""
        motion: Motion = device.move(target, speed=speed or self.speed, owner=owner)
        return motion

    def go(self, device: Any, target: Any) -> None:
        """Move and wait for the end; how it goes is the matter of other clauses."""
        motion = self.move(device, target)
        for _ in self.ticks(self.patience(device, target)):
            if motion.poll() is not MotionState.MOVING:
                return
        fault(f"a motion to {shown(target)} does not end")

    def patience(self, device: Any, target: Any, speed: float | None = None) -> float:
        """Return after what time a motion should surely have ended, s."""
        wanted = 3.0 * distance(self.place(device), target) / (speed or self.speed) + 3.0 + self.contract.latency
        return min(wanted, _LONGEST)  # a place that is wrong by orders must not make a test wait for an hour

    def break_connection(self) -> None:
        """Cut the device off, as the contract says."""
        assert self.contract.cut is not None
        call_with(self.contract.cut, self.simulator)

    def put_load(self, device: Any) -> None:
        """Put a load on a force sensor, as the contract says: on its simulator, or on the open device where there is none."""
        assert self.contract.load is not None
        call_with(self.contract.load, device if self.simulator is None else self.simulator)


def distance(one: Any, other: Any) -> float:
    """Return how far two openings or poses are apart, m."""
    if isinstance(one, Pose):
        return float(sum((a - b) ** 2 for a, b in zip(one.position, other.position, strict=True)) ** 0.5)
    return float(abs(one - other))


def angle(one: Pose, other: Pose) -> float:
    """Return by how much a hand is turned from one pose to another, rad."""
    turn = one.matrix().T @ other.matrix()
    sine = math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / 2
    return math.atan2(sine, (float(np.trace(turn)) - 1) / 2)


def shown(place: Any) -> str:
    """Return a place in words."""
    if isinstance(place, Pose):
        return f"({', '.join(f'{1e3 * v:.1f}' for v in place.position)}) mm"
    return f"{1e3 * place:.1f} mm"


def threads() -> set[threading.Thread]:
    """Return the threads that run now."""
    return {thread for thread in threading.enumerate() if thread.is_alive()}
