"""Whether an arm can take the hand along a path: asked before anything is sent to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.frames import Pose
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.transforms import Array, inverse, transform_of
from stretch_bt.hardware.ur.kinematics import JOINTS, MODELS

__all__ = ["Obstacle", "Reach"]

_APART = 0.005
_MOST_SAMPLES = 400
#: part of the wanted speed below which a path is refused rather than slowed
_SLOWEST = 0.2
#: joints turn two rounds, less what is kept free
_TURN = 2 * math.pi - 0.1


class Obstacle(NamedTuple):
    """What keeps an arm from a path: the reason, and the limits that it concerns, as `BeyondLimits` has them."""

    reason: str
    concerns: tuple[str, ...] = ()


class Reach:
    """The reach of one arm where it stands.

    Parameters
    ----------
    model
        Name of the robot.
    base, hand
        Poses of the robot's base in the world, and of the hand at the flange.
    joint_speed
        Speed that no joint may exceed, rad/s.
    margin
        Least distance to singular poses, as `Kinematics.margin`.
    """

    def __init__(self, model: str, base: Pose, hand: Pose, *, joint_speed: float, margin: float) -> None:
        self._kinematics = MODELS[model]
        self._from_world, self._from_hand = inverse(transform_of(base)), inverse(transform_of(hand))
        self._joint_speed, self._margin = joint_speed, margin

    def obstacle(self, path: PosePath, speed: float, q: Sequence[float]) -> Obstacle | None:
        """Return what keeps the arm from the path at a speed, m/s, from joint angles, rad; None when nothing does.

        A path on which a joint would turn too fast is slowed by `slowed`; one that would take five times as long is refused.
        """
        here: Array | None = None
        for there, found in self._joints(path, q):
            if found is None:
                return self._said(there, "cannot be reached from here in a straight line")
            if (wrong := self._wrong(found)) is not None:
                return self._said(there, wrong)
            if here is not None:
                wrong = self._too_fast(np.abs(found - here) * (_SLOWEST * speed / self._step(path)))
                if wrong is not None:
                    return self._said(there, wrong, ("speed", "contact_speed"))
            here = found
        return None

    def slowed(self, path: PosePath, speed: float, q: Sequence[float]) -> float:
        """Return the speed, m/s, `speed` at most, at which no joint turns faster on the path than it may."""
        joints = [found for _, found in self._joints(path, q) if found is not None]
        turned = [float(np.abs(after - before).max()) for before, after in pairwise(joints)]
        fastest = max(turned, default=0.0) / self._step(path)
        return min(speed, self._joint_speed / fastest) if fastest > 0 else speed

    def _joints(self, path: PosePath, q: Sequence[float]) -> Iterator[tuple[Pose, Array | None]]:
        """Yield poses along a path and the joint angles there, rad; None, and then no more, where there are none."""
        here: Array | None = np.asarray(q, dtype=np.float64)
        for k in range(self._count(path) + 1):
            there = path.at(path.length * k / self._count(path))
            assert here is not None
            try:
                here = self._kinematics.inverse(self._from_world @ transform_of(there) @ self._from_hand, here)
            except IllConditioned:
                here = None
            yield there, here
            if here is None:
                return

    def _count(self, path: PosePath) -> int:
        return min(max(math.ceil(path.length / _APART), 1), _MOST_SAMPLES)

    def _step(self, path: PosePath) -> float:
        return max(path.length / self._count(path), 1e-9)

    def _too_fast(self, speeds: Array) -> str | None:
        fastest = int(np.argmax(speeds))
        if speeds[fastest] <= self._joint_speed:
            return None
        degrees, most = math.degrees(speeds[fastest] / _SLOWEST), math.degrees(self._joint_speed)
        return f"would have {JOINTS[fastest]} turn at {degrees:.0f} deg/s, allowed are {most:.0f}; go slower"

    def _wrong(self, q: Array) -> str | None:
        if float(np.abs(q).max()) > _TURN:
            return f"would turn {JOINTS[int(np.argmax(np.abs(q)))]} past its two rounds; turn it back at the pendant"
        margin = self._kinematics.margin(q)
        if margin < self._margin:
            return (
                f"is too near to where the arm is stretched out or folded ({margin:.3f}, allowed are {self._margin:g})"
            )
        return None

    def _said(self, pose: Pose, what: str, concerns: tuple[str, ...] = ()) -> Obstacle:
        x, y, z = (f"{1e3 * v:.0f}" for v in pose.position)
        return Obstacle(f"the pose {x}, {y}, {z} mm {what}", concerns)
