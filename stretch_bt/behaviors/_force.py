"""Means of a force sensor's readings: fresh ones, along the hand's axis, from a sensor that answers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import Arm, ForceSensor
from stretch_bt.tree.context import Context
from stretch_bt.units import Estimate

__all__ = ["ForceMean", "zero_of"]

MAX_AGE = 0.2
_SILENT = 1.0  # s without a new reading
_APART = 5e-4  # m between two measurements whose forces cannot be the same to the last digit
_DEEP = 1e-3  # m past first contact from which on there is a force

Readings = list[tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class _Last:
    """The only force that a measurement read, N, if there was only one, and the height of the hand then, m."""

    alone: tuple[float, float, float] | None
    height: float


class ForceMean:
    """Collects readings of a force sensor while the hand stands still; a new one for each measurement."""

    def __init__(self, context: Context, sensor: ForceSensor, arm: Arm | None) -> None:
        self.context, self.sensor, self.arm = context, sensor, arm
        self.forces: Readings = []
        self.newest: int | None = None
        self.since = self.heard = context.now

    def add(self) -> int:
        """Take the latest reading if it is a new one taken since the start, and return how many there are.

        Raises
        ------
        IllConditioned
            The sensor has had no new reading for a second.
        """
        reading = self.sensor.wrench(MAX_AGE)
        if reading.sequence != self.newest and reading.host_time >= self.since - 1e-9:
            self.newest, self.heard = reading.sequence, self.context.now
            self.forces.append(reading.value.force)
        elif self.context.now - self.heard > _SILENT:
            raise IllConditioned(f"the force sensor has had no new reading for {_SILENT:g} s; look after it")
        return len(self.forces)

    def mean(self) -> Estimate:
        """Return the mean force along the hand's axis, N, away from the object, with its standard error.

        Raises
        ------
        IllConditioned
            The sensor is stuck.
        """
        pose = (
            Pose() if self.arm is None else self.arm.pose(MAX_AGE).value
        )  # without an arm the hand points straight down
        if self.arm is not None:
            self._check_moving(pose)
        along = np.asarray(self.forces) @ pose.matrix()[:, 2]
        spread = float(along.std(ddof=1)) if len(set(self.forces)) > 1 else 0.0
        return Estimate(float(along.mean()), spread / math.sqrt(along.size))

    def _check_moving(self, pose: Pose) -> None:
        """Refuse readings that are alike to the last digit here and where the hand stood before, at another depth in contact."""
        memory, key = self.context.memory, (_Last, id(self.sensor))
        alone = self.forces[0] if len(set(self.forces)) == 1 else None
        last: _Last | None = memory.get(key)
        memory[key] = _Last(alone, pose.height)
        depth = self.context.hand.depth(pose.height)
        if alone is None or last is None or last.alone != alone or depth is None or depth < _DEEP:
            return
        if abs(pose.height - last.height) > _APART:
            force = math.hypot(*alone)
            raise IllConditioned(
                f"the force sensor says {force:.4g} N to the last digit at two depths, so that it is stuck; look after it"
            )


def zero_of(context: Context, sensor: ForceSensor) -> dict[str, Estimate]:
    """Return where the run keeps what a force sensor says without a load, under `zero`; empty before `zero_force`."""
    found: dict[str, Estimate] = context.memory.setdefault((ForceMean, id(sensor)), {})
    return found
