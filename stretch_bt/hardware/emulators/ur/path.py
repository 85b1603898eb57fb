"""A path of many moves, as the script that ur_rtde uploads has it.

Assumed, because no page says it: lines of one speed that follow each other are passed without a stop; between others the arm comes to rest.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel, JointMove, LineMove, Move, positive
from stretch_bt.hardware.transforms import six, transform

__all__ = ["Leg", "PathMove", "parse_path"]

_LEG = re.compile(r"\bmove([jlp])\((p?)\[([^\]\n]*)\],a=([^,)\n]*),v=([^,)\n]*),r=[^)\n]*\)")
_JOINTS = "j"


@dataclass(frozen=True, slots=True)
class Leg:
    """One move of a path: a line, or all joints in step for the kind `j`.

    `place` is a pose, m and rad, or else six joint angles, rad; `speed` and `acceleration` are those of the tool in m/s and m/s², of
    the fastest joint in rad/s and rad/s².
    """

    kind: str
    is_pose: bool
    place: tuple[float, ...]
    speed: float
    acceleration: float


def parse_path(text: str) -> list[Leg]:
    """Return the legs that a script has as literals; raises ValueError where one has no six numbers, a speed and an acceleration."""
    legs = []
    for kind, pose, place, acceleration, speed in _LEG.findall(text):
        numbers = tuple(float(value) for value in place.split(","))
        if len(numbers) != 6:
            raise ValueError(f"a place has 6 numbers, not {len(numbers)}")
        legs.append(Leg(kind, bool(pose), numbers, float(speed), float(acceleration)))
    return legs


class PathMove(Move):
    """Moves one after the other; raises IllConditioned where one has no place, no speed or no acceleration."""

    def __init__(self, legs: Sequence[Leg]) -> None:
        for number, leg in enumerate(legs, 1):
            _check(leg, f"leg {number} of the path: ")
        self._parts = [[leg for _, leg in part] for _, part in groupby(enumerate(legs), lambda pair: _together(*pair))]
        self._at = self._gone = 0  # parts and legs that are over
        self._now: JointMove | LineMove | None = None

    @property
    def leg(self) -> int:
        """Which of the legs it is on, from 0."""
        return self._gone + (self._now.leg if isinstance(self._now, LineMove) else 0)

    def step(self, arm: ArmModel, dt: float) -> bool:
        """Go on along the legs; each begins where the arm then is."""
        if self._at == len(self._parts):
            return True
        part = self._parts[self._at]
        self._now = self._now or _begun(arm, part)
        if self._now.step(arm, dt):
            self._at, self._gone, self._now = self._at + 1, self._gone + len(part), None
        return self._at == len(self._parts)


def _check(leg: Leg, where: str) -> None:
    wrong = next((value for value in leg.place if not math.isfinite(value)), None)
    if wrong is not None:
        raise IllConditioned(f"{where}{wrong} is no place")
    positive(leg.acceleration, f"{where}a")
    positive(leg.speed, f"{where}v")


def _together(number: int, leg: Leg) -> tuple[float, ...]:
    """Return what lines have alike that are passed without a stop."""
    return (number,) if leg.kind == _JOINTS else (-1, leg.speed, leg.acceleration)


def _begun(arm: ArmModel, part: Sequence[Leg]) -> JointMove | LineMove:
    """Return the move of legs that are gone together; raises IllConditioned for a place out of reach."""
    first = part[0]
    if first.kind == _JOINTS:
        there = arm.joints_for(transform(first.place)) if first.is_pose else np.array(first.place)
        return JointMove(arm, there, first.speed, first.acceleration)
    places = [leg.place if leg.is_pose else six(arm.kinematics.forward(leg.place) @ arm.tcp) for leg in part]
    return LineMove(arm, places, first.speed, first.acceleration)
