"""The program that ur_rtde uploads: recognised by its name, played by its commands rather than by its text.

Commands come in `input_int` registers with their arguments in `input_double` ones, and are answered in output registers; the numbers
come from the script `rtde_control` that ur_rtde 1.6 sends. The text decides where the registers begin and which path is in it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.arm_model import JointMove, LineMove, Move, ServoMotion, SpeedJ, SpeedL
from stretch_bt.hardware.emulators.ur.controller import Controller, Program, ProgramEnded
from stretch_bt.hardware.emulators.ur.path import Leg, PathMove, parse_path
from stretch_bt.hardware.transforms import Array, inverse, six, transform

__all__ = ["ControlScript", "parse_script"]

_READY, _DONE = 1, 2
_CONTACT = 5.0
_OFFSETS = re.compile(r"# (float|int) register offset\n(\d+)")
_REALTIME = {6, 9, 10, 11, 24, 25, 26, 27, 38, 58, 66, 67, 68, 69, 70, 71}
_STOP_SCRIPT = 255


def parse_script(text: str) -> tuple[int, list[Leg]] | None:
    """Return where the registers of a control script begin, and its path; None for another text."""
    offsets = {kind: int(at) for kind, at in _OFFSETS.findall(text)}
    if "def rtde_control():" not in text or set(offsets) != {"float", "int"} or offsets["int"] not in (0, 24):
        return None
    try:
        return offsets["int"], parse_path(text)
    except ValueError:
        return None


class ControlScript:
    """Plays the script in a controller; `run()` is its program."""

    def __init__(self, controller: Controller, base: int, path: list[Leg]) -> None:
        self._controller, self._base, self._path = controller, base, path
        self._arm = controller.arm
        self._moving: Move | None = None
        self._count = self._operation = 0
        self._told_leg = -1
        self._commands: dict[int, Callable[[], Program | None]] = {
            1: lambda: self._joint_move(self._doubles(0, 6)),
            2: lambda: self._joint_move(self._joints()),
            3: lambda: self._line_move(self._doubles(0, 6), *self._doubles(6, 8)),
            4: lambda: self._line_move(self._forward(self._doubles(0, 6)), *self._doubles(6, 8)),
            8: self._controller.zero_force,
            9: lambda: self._speed(SpeedJ(self._doubles(0, 6), self._double(6))),
            10: lambda: self._speed(SpeedL(self._doubles(0, 6), self._double(6))),
            11: lambda: self._servo(np.array(self._doubles(0, 6))),
            15: lambda: self._stop(self._double(0)),
            16: lambda: self._stop(self._double(0)),
            17: self._set_payload,
            24: lambda: self._servo(self._joints()),
            29: self._set_tcp,
            30: lambda: self._answer(self._joints(self._doubles(6, 12))),
            31: self._protective_stop,
            33: lambda: self._stop(self._double(0)),
            34: lambda: self._stop(self._double(0)),
            35: lambda: controller.set_watchdog(base, self._double(0)),
            36: lambda: self._tell(self._reachable()),
            37: lambda: self._tell(True),
            39: lambda: self._answer(six(transform(self._doubles(0, 6)) @ transform(self._doubles(6, 12)))),
            40: lambda: self._answer(six(self._arm.tcp)),
            43: lambda: self._answer(self._arm.tcp_pose),
            44: self._forward_args,
            45: self._move_path,
            46: lambda: self._answer(self._joints()),
            47: lambda: self._tell(self._arm.steady),
            51: self._move_until_contact,
            58: lambda: self._answer(six(self._arm.pose() @ inverse(self._arm.tcp))),
            60: lambda: self._tell(self._reachable()),
            61: lambda: self._tell(self._reachable()),
        }

    def run(self) -> Program:
        """Take commands until one ends it."""
        yield from self._settle(0.03)
        self._progress(-1)
        self._signal(_READY)
        executing = False
        while True:
            command = self._controller.registers.in_int[self._base]
            deaf = self._controller.shown("deaf") is not None
            if command in _REALTIME:
                if not deaf:
                    yield from self._do(command)
                self._signal(_READY)
            elif command == 0:
                executing = False
                self._signal(_READY)
            elif not executing:
                if command == _STOP_SCRIPT:
                    return
                if not deaf:
                    yield from self._do(command)
                self._signal(_DONE)
                executing = True
            self._follow_move()
            yield

    def _do(self, command: int) -> Program:
        """Do a command; one that is not modelled ends the program, so that nobody takes it for done."""
        if command not in self._commands:
            raise IllConditioned(f"command {command} is not modelled")
        blocking = self._commands[command]()
        if blocking is not None:
            yield from blocking

    def _settle(self, seconds: float) -> Program:
        end = self._controller.time + seconds
        while self._controller.time < end:
            yield

    # --- registers

    def _double(self, k: int) -> float:
        return self._controller.registers.in_double[self._base + k]

    def _doubles(self, first: int, end: int) -> list[float]:
        return self._controller.registers.in_double[self._base + first : self._base + end]

    def _is_asynchronous(self) -> bool:
        return self._controller.registers.in_int[self._base + 1] == 1

    def _signal(self, state: int) -> None:
        self._controller.registers.out_int[self._base] = state

    def _tell(self, value: bool) -> None:
        self._controller.registers.out_int[self._base + 1] = int(value)

    def _answer(self, values: Iterable[float]) -> None:
        for k, value in enumerate(values):
            self._controller.registers.out_double[self._base + k] = float(value)

    def _progress(self, value: int) -> None:
        """Write how far an asynchronous move is: 0 as it begins, -1 as it ends."""
        self._count = (self._count + 1) % 128
        self._operation = (self._operation + 1) % 128 if value == 0 else self._operation
        word = self._count << 16 | self._operation << 24
        self._controller.registers.out_int[self._base + 2] = word | (min(value, 32767) | 1 << 15 if value >= 0 else 0)

    # --- moves

    def _joint_move(self, q: Array | list[float]) -> Program | None:
        speed, acceleration = self._doubles(6, 8)
        return self._begin(JointMove(self._arm, q, speed, acceleration))

    def _line_move(self, place: list[float], speed: float, acceleration: float) -> Program | None:
        return self._begin(LineMove(self._arm, [place], speed, acceleration))

    def _move_path(self) -> Program | None:
        return self._begin(PathMove(self._path)) if self._path else None

    def _begin(self, move: Move) -> Program | None:
        if self._moving is not None:
            self._progress(-1)
        self._arm.move, self._moving = move, None
        if not self._is_asynchronous():
            return self._until_over(move)
        self._moving, self._told_leg = move, 0
        self._progress(0)
        return None

    def _until_over(self, move: Move) -> Program:
        yield
        while self._arm.move is move:
            yield

    def _follow_move(self) -> None:
        """Say how far an asynchronous move is."""
        if self._moving is None:
            return
        if self._arm.move is not self._moving:
            self._moving = None
            self._progress(-1)
        elif isinstance(self._moving, PathMove) and self._moving.leg > self._told_leg:
            self._told_leg = self._moving.leg
            self._progress(self._told_leg)

    def _speed(self, move: SpeedJ | SpeedL) -> None:
        now = self._arm.move
        if isinstance(now, type(move)):
            now.target, now.acceleration = move.target, move.acceleration
        else:
            self._arm.move = move

    def _servo(self, q: Array) -> None:
        lag = min(max(self._double(9), 0.03), 0.2)
        now = self._arm.move
        if isinstance(now, ServoMotion):
            now.target, now.lag = q, lag
        else:
            self._arm.move = ServoMotion(q, lag)

    def _stop(self, deceleration: float) -> Program:
        if self._moving is not None:
            self._moving = None
            self._progress(-1)
        return self._until_over(self._controller.halt(deceleration, joints=False))

    def _move_until_contact(self) -> Program | None:
        """On a CB3 the script has no such command: it is done at once, without a move."""
        if not self._controller.profile.e_series:
            return None
        return self._seek(SpeedL(self._doubles(0, 6), self._double(12)))

    def _seek(self, move: SpeedL) -> Program:
        self._arm.move = move
        while float(np.linalg.norm(self._controller.force()[:3])) < _CONTACT:
            yield
        yield from self._stop(3.0)

    # --- settings and questions

    def _joints(self, near: list[float] | None = None) -> Array:
        """Return the joint angles for the pose in the first registers; there are none while the fault says so."""
        if self._controller.shown("no_solution") is not None:
            raise IllConditioned("get_inverse_kin: no solution")
        return self._arm.joints_for(transform(self._doubles(0, 6)), near)

    def _protective_stop(self) -> None:
        self._controller.stop_safely("protective_stop", "the program asked for it")
        raise ProgramEnded

    def _set_tcp(self) -> None:
        self._arm.tcp = transform(self._doubles(0, 6))

    def _set_payload(self) -> None:
        mass, *centre = self._doubles(0, 4)
        self._controller.payload = mass
        if any(centre):
            self._controller.payload_cog = tuple(centre)

    def _forward(self, q: list[float]) -> list[float]:
        return six(self._arm.kinematics.forward(q) @ self._arm.tcp)

    def _forward_args(self) -> None:
        flange = self._arm.kinematics.forward(self._doubles(0, 6))
        self._answer(six(flange @ transform(self._doubles(6, 12))))

    def _reachable(self) -> bool:
        try:
            self._joints()
        except IllConditioned:
            return False
        return True
