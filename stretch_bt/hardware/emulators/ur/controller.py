"""The state of a controller: power, safety, registers, the program that runs, the arm.

Its clock counts cycles, so that it goes slower where the machine is too busy to keep its pace.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel, Slowing

__all__ = ["REGISTERS", "SAFETY", "Controller", "Profile", "Program", "ProgramEnded", "Registers", "Safety"]

#: general purpose registers of each kind and direction
REGISTERS = 48

_RUNNING, _IDLE, _POWER_ON, _POWER_OFF = 7, 5, 4, 3
_STOPPED, _PLAYING = 1, 2
#: by the maker's pages, how long a protective stop lasts before it can be unlocked, s
_LOCKED = 5.0
_STOP_AT = 10.0


class ProgramEnded(Exception):
    """A program did what ends itself."""


class Safety(NamedTuple):
    """A state of the safety system: its names on the dashboard, number and bits."""

    name: str
    mode: int
    bits: int


#: groups of eight digital outputs, the lowest bits first
_OUTPUTS = ("standard_digital_output", "configurable_digital_output", "tool_digital_output")

_NORMAL, _STOPS = 1 << 0, 1 << 10
SAFETY: dict[str, Safety] = {
    "normal": Safety("NORMAL", 1, _NORMAL),
    "protective_stop": Safety("PROTECTIVE_STOP", 3, 1 << 2 | _STOPS),
    "safeguard_stop": Safety("SAFEGUARD_STOP", 5, 1 << 4 | _STOPS),
    "emergency_stop": Safety("ROBOT_EMERGENCY_STOP", 7, 1 << 6 | 1 << 7 | _STOPS),
    "violation": Safety("VIOLATION", 8, 1 << 8 | _STOPS),
    "fault": Safety("FAULT", 9, 1 << 9 | _STOPS),
}


class Profile(NamedTuple):
    """What a model of controller is: version (major, minor, bugfix, build), cycles a second, name, serial number."""

    version: tuple[int, int, int, int]
    rate: float
    model: str
    serial: str

    @property
    def e_series(self) -> bool:
        """Whether it is newer than a CB3."""
        return self.version[0] >= 5


@dataclass
class Registers:
    """The general purpose registers, and when each integer one was last written, s of the controller."""

    in_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    in_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    out_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    out_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    written: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)


#: one step each cycle, until it ends
Program = Generator[None, None, None]


class Controller:
    """A controller and its arm; every use is under `lock`.

    Parameters
    ----------
    profile
        What it is.
    arm
        What it moves.
    felt
        Returns the wrench on the tool in base axes, N and N m.
    shown
        Returns the parameters of an active fault, or None.
    """

    def __init__(
        self,
        profile: Profile,
        arm: ArmModel,
        felt: Callable[[], tuple[float, ...]],
        shown: Callable[[str], dict[str, float] | None],
    ) -> None:
        self.profile, self.arm, self.shown = profile, arm, shown
        self._felt = felt
        self.lock = threading.RLock()
        self.registers = Registers()
        self.time = 0.0
        self.payload = 0.0
        self.digital_outputs = 0
        self.slider = 1.0
        self.powered = self.released = True
        #: what happened, and when, s
        self.events: deque[tuple[float, str]] = deque(maxlen=50)
        self._state = "normal"
        self._locked_until = 0.0
        self._program: Program | None = None
        self._starting: tuple[float, Program] | None = None
        self._watchdog: tuple[int, float] | None = None
        self._zero = np.zeros(6)

    @property
    def safety(self) -> Safety:
        """How the safety system stands."""
        return SAFETY[self._state]

    @property
    def running(self) -> bool:
        """Whether a program runs."""
        return self._program is not None

    @property
    def robot_mode(self) -> int:
        """The robot's mode, by number."""
        if not self.powered:
            return _POWER_OFF
        return _RUNNING if self.released else _IDLE

    @property
    def runtime_state(self) -> int:
        """How the program stands, by number."""
        return _PLAYING if self.running else _STOPPED

    @property
    def status_bits(self) -> int:
        """Power and program."""
        return int(self.powered) | int(self.running) << 1

    @property
    def speed_fraction(self) -> float:
        """The speed slider, or what a fault makes of it."""
        slow = self.shown("slider")
        return min(self.slider, slow["fraction"]) if slow is not None else self.slider

    def force(self) -> tuple[float, ...]:
        """Return the wrench that the controller tells of, N and N m, in base axes."""
        return tuple((np.asarray(self._felt()) - self._zero).tolist())

    def zero_force(self) -> None:
        """Take the present wrench as zero."""
        self._zero = np.asarray(self._felt())

    def cycle(self) -> None:
        """Do what is done in one cycle."""
        period = 1 / self.profile.rate
        self.time += period
        self._watch()
        self._run()
        if self.shown("stall") is not None:
            self.arm.stand()
            return
        try:
            self.arm.step(period, self.speed_fraction if self._state == "normal" else 1.0)
        except (IllConditioned, np.linalg.LinAlgError):
            self.stop_safely("protective_stop", "the arm cannot go on: out of reach, or stretched out")

    def load(self, program: Program, after: float) -> None:
        """Run a program after a time, s; the one before it is stopped."""
        self.stop_program("another program was sent")
        self._starting = self.time + after, program

    def stop_program(self, why: str) -> None:
        """End the program; the arm brakes."""
        self._starting = None
        if self._program is not None:
            self.note(f"program stopped: {why}")
            self._program = None
            self.halt(_STOP_AT)
        self._watchdog = None

    def halt(self, deceleration: float, *, joints: bool = True) -> Slowing:
        """Brake, and return that move."""
        slowing = Slowing(self.arm, deceleration, joints=joints)
        self.arm.move = slowing
        return slowing

    def stop_safely(self, state: str, why: str, locked: float = _LOCKED) -> None:
        """Stop as the safety system does."""
        self.note(f"{state}: {why}")
        self._state = state
        self._locked_until = self.time + locked
        self.stop_program(state)
        self.halt(_STOP_AT)
        if state == "emergency_stop":
            self.powered = self.released = False

    def unlock(self) -> bool:
        """End a protective stop; return False where it is too soon for that."""
        if self._state == "protective_stop":
            if self.time < self._locked_until:
                return False
            self._state = "normal"
        return True

    def release_stop(self, state: str) -> None:
        """End a stop that a person ends: the emergency stop button, the safeguard."""
        if self._state == state:
            self._state = "normal"

    def power(self, *, on: bool) -> None:
        """Switch the arm's power."""
        if not on:
            self.stop_program("power off")
            self.halt(_STOP_AT)
            self.released = False
        self.powered = on and self._state != "emergency_stop"

    def release_brakes(self) -> None:
        """Make a powered arm ready to move."""
        if self._state != "emergency_stop":
            self.powered = self.released = True

    def set_watchdog(self, register: int, rate: float) -> None:
        """Stop the program when nobody writes an integer register `rate` times a second."""
        self._watchdog = (register, 1 / rate) if rate > 0 else None
        self.registers.written[register] = self.time

    def _watch(self) -> None:
        if self._watchdog is None or not self.running:
            return
        register, longest = self._watchdog
        if self.time - self.registers.written[register] > longest:
            self.stop_program("watchdog")

    def _run(self) -> None:
        if self._starting is not None and self.time >= self._starting[0]:
            (_, self._program), self._starting = self._starting, None
            if self.profile.e_series:  # as its maker says
                self.zero_force()
            if self._state != "normal" or not self.released:
                self._program = None
        if self._program is None:
            return
        try:
            next(self._program)
        except ProgramEnded:
            self._program = None
        except StopIteration:
            self._program = None
            self.halt(_STOP_AT)
        except IllConditioned as error:
            self.note(f"program error: {error}")
            self.stop_program("a runtime error")

    def note(self, event: str) -> None:
        """Write down what happened."""
        self.events.append((self.time, event))

    def take(self, inputs: Mapping[str, Any]) -> None:
        """Take the inputs of one package, by name."""
        for name, value in inputs.items():
            kind, _, number = name.rpartition("_")
            if kind == "input_int_register":
                self.registers.in_int[int(number)] = value
                self.registers.written[int(number)] = self.time
            elif kind == "input_double_register" and math.isfinite(value):
                self.registers.in_double[int(number)] = value
        for place, name in enumerate(_OUTPUTS):
            mask = inputs.get(f"{name}_mask", 0) << 8 * place
            self.digital_outputs = self.digital_outputs & ~mask | inputs.get(name, 0) << 8 * place & mask
        if inputs.get("speed_slider_mask") and 0.0 <= inputs["speed_slider_fraction"] <= 1.0:
            self.slider = inputs["speed_slider_fraction"]
