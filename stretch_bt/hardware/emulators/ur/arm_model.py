"""The arm behind the controller: nominal kinematics, finite speeds and accelerations.

Assumed, because no page says it: a servo target is followed with a lag of `lookahead_time`; corners of lines are passed at full speed;
the arm stops a program's motion at 2 rad/s² or 1 m/s²; a line that asks a joint for more than 180 degrees a second ends in a protective
stop. Not modelled: dynamics, collisions with itself, blend radii.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import accumulate, pairwise

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.motion.path import LEVER
from stretch_bt.hardware.motion.profile import Profile
from stretch_bt.hardware.transforms import Array, inverse, rotation_vector, six, transform
from stretch_bt.hardware.ur.kinematics import Kinematics

__all__ = [
    "ArmModel",
    "JointMove",
    "LineMove",
    "Move",
    "ServoMotion",
    "Slowing",
    "SpeedJ",
    "SpeedL",
    "line_length",
    "positive",
]

#: fastest joints of both models, rad/s
_FASTEST = math.pi
_SLOW = 1e-6


class Move(ABC):
    """What moves the arm."""

    @abstractmethod
    def step(self, arm: ArmModel, dt: float) -> bool:
        """Move the arm by a time, s, and return whether that was the end; raises IllConditioned where there is no way on."""


class ArmModel:
    """Six joints, the tool at their end, and what moves them now.

    Parameters
    ----------
    kinematics
        Kinematics of the model.
    q
        Six joint angles at first, rad.
    """

    def __init__(self, kinematics: Kinematics, q: Sequence[float]) -> None:
        self.kinematics = kinematics
        self.q: Array = np.array(q, dtype=np.float64)
        self.qd: Array = np.zeros(6)
        self.tcp: Array = np.eye(4)
        self.move: Move | None = None
        self._framed: tuple[bytes, Array] | None = None
        self._known: tuple[bytes, tuple[float, ...], tuple[float, ...]] | None = None

    def step(self, dt: float, fraction: float = 1.0) -> None:
        """Go on for a time, s, at a part of the speed; raises IllConditioned, and stays, where a joint would pass its limit."""
        before = self.q.copy()
        over = self.move is not None and self.move.step(self, dt * fraction)
        speeds = (self.q - before) / dt
        if not np.abs(speeds).max() < _FASTEST * 1.001:
            self.q = before
            raise IllConditioned("a joint would be faster than it can")
        self.qd, self.move = speeds, None if over else self.move

    def put(self, q: Sequence[float]) -> None:
        """Stand at other joint angles, rad."""
        self.q, self.move = np.array(q, dtype=np.float64), None
        self.qd = np.zeros(6)

    def stand(self) -> None:
        """Go nowhere, whatever the move says; braking is over at once."""
        self.qd = np.zeros(6)
        if isinstance(self.move, Slowing):
            self.move = None

    @property
    def standing(self) -> bool:
        """Whether no joint moves now, though a servo may hold it there."""
        return float(np.abs(self.qd).max()) < _SLOW

    @property
    def steady(self) -> bool:
        """Whether it stands, and nothing is to move it."""
        return self.move is None and self.standing

    def pose(self) -> Array:
        """Return the (4, 4) transform of the tool in the base."""
        made: Array = self.frames()[6] @ self.tcp
        return made

    def frames(self) -> Array:
        """Return the (7, 4, 4) transforms of base, joints and flange in the base; not to be changed."""
        key = self.q.tobytes()
        if self._framed is None or self._framed[0] != key:
            self._framed = key, self.kinematics.frames(self.q)
        return self._framed[1]

    def joints_for(self, tool: Array, near: Sequence[float] | None = None) -> Array:
        """Return the joint angles that put the tool there; raises IllConditioned."""
        return self.kinematics.inverse(tool @ inverse(self.tcp), self.q if near is None else near)

    def jacobian(self) -> Array:
        """Return the (6, 6) Jacobian of the tool in base axes."""
        made = self.kinematics.jacobian(self.q)
        arm = self.frames()[6, :3, :3] @ self.tcp[:3, 3]
        made[:3] += np.cross(made[3:].T, arm).T
        return made

    @property
    def tcp_pose(self) -> tuple[float, ...]:
        """Position, m, and rotation vector, rad, of the tool in the base."""
        return self._told()[1]

    @property
    def tcp_speed(self) -> tuple[float, ...]:
        """Velocity, m/s, and angular velocity, rad/s, of the tool in base axes."""
        return self._told()[2]

    def _told(self) -> tuple[bytes, tuple[float, ...], tuple[float, ...]]:
        key = self.q.tobytes() + self.qd.tobytes() + self.tcp.tobytes()
        if self._known is None or self._known[0] != key:
            speed = tuple((self.jacobian() @ self.qd).tolist()) if self.qd.any() else (0.0,) * 6
            self._known = key, tuple(six(self.pose())), speed
        return self._known


def positive(value: float, name: str) -> float:
    """Return a speed or an acceleration; raises IllConditioned for one at which no arm gets anywhere, as a controller ends its program."""
    if not 0 < value < math.inf:
        raise IllConditioned(f"{name} must be more than 0, and is {value:g}")
    return value


class JointMove(Move):
    """All joints in step, the one with the longest way at speed, rad/s, and acceleration, rad/s²; raises IllConditioned for one of 0."""

    def __init__(self, arm: ArmModel, to: Sequence[float] | Array, speed: float, acceleration: float) -> None:
        self._start, self._way = arm.q.copy(), np.asarray(to, dtype=np.float64) - arm.q
        fastest = min(positive(speed, "v"), _FASTEST)
        self._profile = Profile.trapezoid(float(np.abs(self._way).max()), fastest, positive(acceleration, "a"))
        self._time = 0.0

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on along the way."""
        self._time += dt
        gone, _ = self._profile.at(self._time)
        arm.q = self._start + self._way * (gone / self._profile.length if self._profile.length else 1.0)
        return self._time >= self._profile.duration


class LineMove(Move):
    """The tool in straight lines through places at a speed, m/s, and acceleration, m/s²."""

    def __init__(self, arm: ArmModel, places: Sequence[Sequence[float]], speed: float, acceleration: float) -> None:
        self._places = [arm.pose(), *(transform(place) for place in places)]
        legs = list(pairwise(self._places))
        self._turns = [_turn(a, b) for a, b in legs]
        lengths = [line_length(a, b) for a, b in legs]
        self._ends = list(accumulate(lengths))
        self._begins = [0.0, *self._ends[:-1]]
        self._lengths = lengths
        self._profile = Profile.trapezoid(self._ends[-1], positive(speed, "v"), positive(acceleration, "a"))
        self._time = 0.0

    @property
    def leg(self) -> int:
        """Which of the lines it is on."""
        gone, _ = self._profile.at(self._time)
        return min(sum(end < gone for end in self._ends), len(self._lengths) - 1)

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on along the lines."""
        self._time += dt
        gone, _ = self._profile.at(self._time)
        k = self.leg
        part = (gone - self._begins[k]) / self._lengths[k] if gone < self._ends[k] else 1.0
        a, b = self._places[k], self._places[k + 1]
        place = np.eye(4)
        place[:3, :3] = a[:3, :3] @ transform([0, 0, 0, *(self._turns[k] * part)])[:3, :3]
        place[:3, 3] = a[:3, 3] + part * (b[:3, 3] - a[:3, 3])
        arm.q = arm.joints_for(place)
        return self._time >= self._profile.duration


def line_length(a: Array, b: Array) -> float:
    """Return the length, m, that a line between two places (4, 4) has for its speed; a turn counts by a lever."""
    return max(float(np.linalg.norm(b[:3, 3] - a[:3, 3])), LEVER * float(np.linalg.norm(_turn(a, b))))


def _turn(a: Array, b: Array) -> Array:
    return rotation_vector(a[:3, :3].T @ b[:3, :3])


class SpeedL(Move):
    """The tool at a velocity, m/s and rad/s in base axes, approached at an acceleration, m/s²; for ever."""

    def __init__(self, target: Sequence[float], acceleration: float) -> None:
        self.target, self.acceleration = np.asarray(target, dtype=np.float64), positive(acceleration, "a")
        self._now = np.zeros(6)

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on."""
        change = self.target - self._now
        most = float(np.linalg.norm(change))
        self._now = self._now + change * min(1.0, self.acceleration * dt / most) if most > 0 else self._now
        arm.q = arm.q + np.linalg.solve(arm.jacobian(), self._now) * dt
        return False


class SpeedJ(Move):
    """The joints at speeds, rad/s, approached at an acceleration, rad/s²; for ever."""

    def __init__(self, target: Sequence[float], acceleration: float) -> None:
        self.target = np.clip(np.asarray(target, dtype=np.float64), -_FASTEST, _FASTEST)
        self.acceleration = positive(acceleration, "a")
        self._now: Array | None = None

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on, at first from the speed that the joints have; a stand by the controller leaves the speed that is commanded."""
        now = arm.qd if self._now is None else self._now
        self._now = now + np.clip(self.target - now, -self.acceleration * dt, self.acceleration * dt)
        arm.q = arm.q + self._now * dt
        return False


class ServoMotion(Move):
    """The joints after a target that is set anew all the time, with a lag, s; for ever."""

    def __init__(self, target: Array, lag: float) -> None:
        self.target, self.lag = target, lag

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on."""
        step = (self.target - arm.q) * -math.expm1(-dt / self.lag)
        arm.q = arm.q + np.clip(step, -_FASTEST * dt, _FASTEST * dt)
        return False


class Slowing(Move):
    """From the present speed to rest: the fastest joint at a deceleration, rad/s², or the tool at one, m/s²."""

    def __init__(self, arm: ArmModel, deceleration: float, *, joints: bool) -> None:
        self._speed = arm.qd.copy()
        speed = float(np.abs(arm.qd).max()) if joints else float(np.linalg.norm(arm.tcp_speed[:3]))
        self._duration = speed / deceleration if deceleration > 0 else 0.0
        self._time = 0.0

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on."""
        left = max(self._duration - self._time, 0.0)
        part = min(dt, left)
        if self._duration > 0:
            arm.q = arm.q + self._speed * (left - part / 2) / self._duration * part
        self._time += dt
        return self._time >= self._duration
