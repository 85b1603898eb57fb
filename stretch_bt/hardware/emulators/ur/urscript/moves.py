"""Functions of URScript that take time: moves, stops and waiting."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from stretch_bt.hardware.emulators.ur.arm_model import (
    JointMove,
    LineMove,
    Move,
    ServoMotion,
    SpeedJ,
    SpeedL,
    line_length,
)
from stretch_bt.hardware.emulators.ur.controller import Controller, Program
from stretch_bt.hardware.emulators.ur.urscript.values import Pose, Value, six_of
from stretch_bt.hardware.transforms import six, transform

__all__ = ["move_functions"]

#: part of a move in which it speeds up, and in which it slows down, where it has a time in place of a speed
_RAMP = 1 / 3


def move_functions(controller: Controller) -> Mapping[str, Callable[..., Program]]:
    """Return the functions by name; each returns what is to be done in the cycles that it takes."""
    moves = _Moves(controller)
    return {
        "movej": moves.joints,
        "movel": moves.line,
        "movep": moves.line,
        "speedj": moves.joint_speed,
        "speedl": moves.line_speed,
        "servoj": moves.servo,
        "stopj": lambda a=2.0: moves.stop(a, joints=True),
        "stopl": lambda a=20.0, aRot=0.0: moves.stop(a, joints=False),
        "sleep": lambda t: moves.wait(_positive(t, "t", zero=True)),
        "sync": lambda: moves.wait(0.0),
    }


class _Moves:
    """The moves of one controller's arm."""

    def __init__(self, controller: Controller) -> None:
        self._controller, self._arm = controller, controller.arm

    def joints(self, q: Value, a: float = 1.4, v: float = 1.05, t: float = 0.0, r: float = 0.0) -> Program:
        """Move all joints in step to angles, rad, or to a pose, at a speed, rad/s, or in a time, s."""
        there = self._angles(q)
        way = max(abs(b - c) for b, c in zip(there, self._arm.q, strict=True))
        speed, acceleration = _pace(way, a, v, t)
        return self._until_over(JointMove(self._arm, there, speed, acceleration))

    def line(self, pose: Value, a: float = 1.2, v: float = 0.25, t: float = 0.0, r: float = 0.0) -> Program:
        """Move the tool in a straight line to a pose, or to where joint angles have it, at a speed, m/s, or in a time, s."""
        place = six_of(pose) if isinstance(pose, Pose) else self._place(six_of(pose))
        speed, acceleration = _pace(line_length(self._arm.pose(), transform(place)), a, v, t)
        return self._until_over(LineMove(self._arm, [place], speed, acceleration))

    def joint_speed(self, qd: Value, a: float, t: float = 0.0) -> Program:
        """Turn the joints at speeds, rad/s; go on to the next line after a time, s, or when they are reached."""
        return self._at_speed(SpeedJ(six_of(qd), _positive(a, "a")), t)

    def line_speed(self, xd: Value, a: float, t: float = 0.0, aRot: float = 0.0) -> Program:
        """Move the tool at a velocity, m/s and rad/s; go on to the next line after a time, s, or when it is reached."""
        return self._at_speed(SpeedL(six_of(xd), _positive(a, "a")), t)

    def servo(
        self,
        q: Value,
        a: float = 0.0,
        v: float = 0.0,
        t: float = 0.0,
        lookahead_time: float = 0.1,
        gain: float = 300.0,
    ) -> Program:
        """Follow a target of joint angles, rad, for a time, s."""
        lag = min(max(_positive(lookahead_time, "lookahead_time"), 0.03), 0.2)
        self._arm.move = ServoMotion(np.array(self._angles(q)), lag)
        return self.wait(t)

    def stop(self, a: float, *, joints: bool) -> Program:
        """Brake, at rad/s² or m/s²."""
        return self._until_over(self._controller.halt(_positive(a, "a"), joints=joints), begun=True)

    def wait(self, time: float) -> Program:
        """Let a time pass, s, one cycle at least."""
        end = self._controller.time + time
        yield
        while self._controller.time < end - 1e-9:
            yield

    def _angles(self, value: Value) -> list[float]:
        if not isinstance(value, Pose):
            return six_of(value)
        found: list[float] = self._arm.joints_for(transform(six_of(value))).tolist()
        return found

    def _place(self, q: list[float]) -> list[float]:
        matrix = self._arm.kinematics.forward(q) @ self._arm.tcp
        return six(matrix)

    def _until_over(self, move: Move, *, begun: bool = False) -> Program:
        if not begun:
            self._arm.move = move
        yield
        while self._arm.move is move:
            yield

    def _at_speed(self, move: SpeedJ | SpeedL, t: float) -> Program:
        now = self._arm.move
        if isinstance(now, type(move)):
            now.target, now.acceleration = move.target, move.acceleration
        else:
            self._arm.move = move
        if t > 0:
            return self.wait(t)
        return self.wait(float(abs(move.target).max()) / move.acceleration)


def _pace(way: float, a: float, v: float, t: float) -> tuple[float, float]:
    """Return speed and acceleration of a move; a time takes the place of both."""
    if t > 0 and way > 0:
        speed = way / (t * (1 - _RAMP))
        return speed, speed / (t * _RAMP)
    return _positive(v, "v"), _positive(a, "a")


def _positive(value: Value, name: str, *, zero: bool = False) -> float:
    if not isinstance(value, int | float) or not (value > 0 or (zero and value == 0)) or not math.isfinite(value):
        raise ValueError(f"{name} must be more than 0")
    return float(value)
