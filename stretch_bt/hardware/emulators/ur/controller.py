"""The state of a controller: power, safety, registers, the program that runs, the arm.

Its clock counts cycles, so that it goes slower where the machine is too busy to keep its pace.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Generator, Mapping
from functools import reduce
from operator import or_
from typing import Any, NamedTuple

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel, Slowing
from stretch_bt.hardware.emulators.ur.registers import AnalogOutputs, Registers
from stretch_bt.hardware.emulators.ur.safety import SAFETY, Safety

__all__ = ["Controller", "ControllerModel", "Program", "ProgramEnded"]

_RUNNING, _IDLE, _POWER_ON, _POWER_OFF = 7, 5, 4, 3
_STOPPED, _PLAYING, _PAUSED = 1, 2, 4
#: modes of joints and of the tool
_JOINT_OFF, _JOINT_RUNNING, _JOINT_IDLE = 239, 253, 255
#: least duration of a protective stop before it can be unlocked, s, by the maker's pages
_LOCKED = 5.0
_STOP_AT = 10.0


class ProgramEnded(Exception):
    """A program did what ends itself."""


#: groups of eight digital outputs, the lowest bits first
_OUTPUTS = ("standard_digital_output", "configurable_digital_output", "tool_digital_output")


class ControllerModel(NamedTuple):
    """What a model of controller is: version (major, minor, bugfix, build), cycles a second, name, serial number."""

    version: tuple[int, int, int, int]
    rate: float
    model: str
    serial: str

    @property
    def e_series(self) -> bool:
        """Whether it is newer than a CB3."""
        return self.version[0] >= 5


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
        profile: ControllerModel,
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
        self.payload_cog: tuple[float, ...] = (0.0,) * 3
        self.payload_inertia: tuple[float, ...] = (0.0,) * 6
        self.digital_outputs = 0
        self.analog = AnalogOutputs()
        self.slider = 1.0
        self.powered = self.released = True
        self.paused = False
        #: line of the program that moves the arm, 0 where none says it
        self.script_line = 0
        #: time of each event, s, and its name
        self.events: deque[tuple[float, str]] = deque(maxlen=50)
        #: stops that were made and not ended; they exist side by side
        self._stops: set[str] = set()
        self._locked_until = 0.0
        self._program: Program | None = None
        self._starting: tuple[float, Program] | None = None
        self._watchdog: tuple[int, float] | None = None
        self._zero = np.zeros(6)

    @property
    def safety(self) -> Safety:
        """How the safety system stands: the gravest of its stops, with the bits of all."""
        here = [told for name, told in SAFETY.items() if name in self._stops] or [SAFETY["normal"]]
        return here[-1]._replace(bits=reduce(or_, (told.bits for told in here)))

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
    def joint_mode(self) -> int:
        """The mode of each joint, by number."""
        if not self.powered:
            return _JOINT_OFF
        return _JOINT_RUNNING if self.released else _JOINT_IDLE

    @property
    def tool_mode(self) -> int:
        """The mode of the tool, by number."""
        return _JOINT_RUNNING if self.powered else _JOINT_IDLE

    @property
    def runtime_state(self) -> int:
        """How the program stands, by number."""
        if not self.running:
            return _STOPPED
        return _PAUSED if self.paused else _PLAYING

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
        """Return the wrench that the controller reports, N and N m, in base axes."""
        return tuple((np.asarray(self._felt()) - self._zero).tolist())

    def raw_force(self) -> tuple[float, ...]:
        """Return the wrench as it is measured, N and N m, in axes of the flange, whatever was taken as zero."""
        turn = self.arm.frames()[6, :3, :3].T
        felt = np.asarray(self._felt())
        return (*(turn @ felt[:3]).tolist(), *(turn @ felt[3:]).tolist())

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
            self.arm.step(period, self._pace())
        except (IllConditioned, np.linalg.LinAlgError):
            self.stop_safely(
                "protective_stop", "the arm cannot go on: out of reach, stretched out, or a joint too fast"
            )

    def _pace(self) -> float:
        """Return at which part of its speed the arm moves; a stop does not wait for the slider."""
        if self._stops:
            return 1.0
        return 0.0 if self.paused else self.speed_fraction

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
        self.paused, self.script_line = False, 0

    def pause(self) -> bool:
        """Hold the program and the arm where they are; return False where nothing runs."""
        self.paused = self.running
        return self.paused

    def resume(self) -> bool:
        """Go on with a program that is held; return False where there is none."""
        held, self.paused = self.paused, False
        return held

    def halt(self, deceleration: float, *, joints: bool = True) -> Slowing:
        """Brake, and return that move; an arm whose move has ended stands already."""
        if self.arm.move is None:
            self.arm.stand()
        slowing = Slowing(self.arm, deceleration, joints=joints)
        self.arm.move = slowing
        return slowing

    def stop_safely(self, state: str, why: str, locked: float = _LOCKED) -> None:
        """Stop as the safety system does."""
        self.note(f"{state}: {why}")
        self._stops.add(state)
        if state == "protective_stop":
            self._locked_until = self.time + locked
        self.stop_program(state)
        self.halt(_STOP_AT)
        if state == "emergency_stop":
            self.powered = self.released = False

    def unlock(self) -> bool:
        """End a protective stop, and no other one; return False where it is too soon for that."""
        if "protective_stop" in self._stops and self.time < self._locked_until:
            return False
        self._stops.discard("protective_stop")
        return True

    def release_stop(self, state: str) -> None:
        """End a stop that a person ends: the emergency stop button, the safeguard."""
        self._stops.discard(state)

    def power(self, *, on: bool) -> None:
        """Switch the arm's power."""
        if not on:
            self.stop_program("power off")
            self.halt(_STOP_AT)
            self.released = False
        self.powered = on and "emergency_stop" not in self._stops

    def release_brakes(self) -> None:
        """Make a powered arm ready to move."""
        if "emergency_stop" not in self._stops:
            self.powered = self.released = True

    def set_watchdog(self, register: int, rate: float) -> None:
        """Stop the program when nobody writes an integer register `rate` times a second."""
        self._watchdog = (register, 1 / rate) if rate > 0 else None
        self.registers.written[register] = self.time

    def _watch(self) -> None:
        if self._watchdog is None or not self.running or self.paused:
            return
        register, longest = self._watchdog
        if self.time - self.registers.written[register] > longest:
            self.stop_program("watchdog")

    def _run(self) -> None:
        if self._starting is not None and self.time >= self._starting[0]:
            (_, self._program), self._starting = self._starting, None
            if self.profile.e_series:  # as its maker says
                self.zero_force()
            if self._stops or not self.released:
                self._program = None
        if self._program is None or self.paused:
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
            self.registers.take(name, value, self.time)
            if name.startswith("input_double_register_") and not math.isfinite(value):
                self.stop_program(f"{name} is {value}: no arm goes by that")
        for place, name in enumerate(_OUTPUTS):
            mask = inputs.get(f"{name}_mask", 0) << 8 * place
            self.digital_outputs = self.digital_outputs & ~mask | inputs.get(name, 0) << 8 * place & mask
        self.analog.take(inputs)
        if inputs.get("speed_slider_mask") and 0.0 <= inputs.get("speed_slider_fraction", -1.0) <= 1.0:
            self.slider = inputs["speed_slider_fraction"]
