"""The force along the hand's axis, and means of a force sensor's readings of it: fresh ones, from a sensor that answers."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from stretch_bt.behaviors.records import ForceSample, Touch
from stretch_bt.errors import IllConditioned
from stretch_bt.frames import Pose
from stretch_bt.hardware.ages import FORCE, PRESSING_PLACE
from stretch_bt.hardware.interfaces import Arm, ForceSensor
from stretch_bt.tree.context import Context
from stretch_bt.units import Estimate

__all__ = ["ForceMean", "along_hand", "check_alive"]

_SILENT = 1.0  # s without a new reading
_APART = 5e-4  # m between two measurements whose forces cannot be the same to the last digit
_DEEP = 1e-3  # m past first contact; deeper there is a force

Readings = list[tuple[float, float, float]]


def along_hand(forces: npt.ArrayLike, pose: Pose) -> npt.NDArray[np.float64]:
    """Return forces (..., 3), N, of wrenches in world axes, along the axis (...) of a hand at a pose, away from the object."""
    return np.asarray(forces, dtype=np.float64) @ pose.matrix()[:, 2]


class ForceMean:
    """Collects readings of a force sensor while the hand stands still; a new one for each measurement."""

    def __init__(self, context: Context, sensor: ForceSensor | Arm, arm: Arm | None) -> None:
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
        reading = self.sensor.wrench(FORCE)
        if reading.sequence != self.newest and reading.host_time >= self.since - 1e-9:
            self.newest, self.heard = reading.sequence, self.context.now
            self.forces.append(reading.value.force)
        elif self.context.now - self.heard > _SILENT:
            name = "arm's force" if self.sensor is self.arm else "force sensor"
            raise IllConditioned(f"the {name} has had no new reading for {_SILENT:g} s; look after it")
        return len(self.forces)

    def sample(self) -> ForceSample:
        """Return the mean force along the hand's axis, N, away from the object, with its standard error."""
        # without an arm the hand points straight down
        pose = Pose() if self.arm is None else self.arm.pose(PRESSING_PLACE).value
        along = along_hand(self.forces, pose)
        alone = len(set(self.forces)) == 1
        spread = 0.0 if alone else float(along.std(ddof=1))
        return ForceSample(
            float(along.mean()),
            spread / math.sqrt(along.size),
            None if self.arm is None else pose.height,
            self.forces[0] if alone else None,
        )

    def estimate(self, noise: float) -> Estimate:
        """Return the mean, N, of a sensor whose mean over a time is known to vary by `noise`, N s^0.5, over the root of the time."""
        found = self.sample()
        over = self.heard - self.since
        return Estimate(found.force, max(found.force_sd, noise / math.sqrt(over) if over > 0 else 0.0))


def check_alive(sample: ForceSample, before: Iterable[ForceSample | None], touch: Touch | None) -> None:
    """Refuse a sample whose readings all equal an earlier sample's to the last digit, at another depth in contact.

    Raises
    ------
    IllConditioned
        The sensor is stuck.
    """
    if sample.stuck_at is None or sample.height is None or touch is None or touch.height - sample.height < _DEEP:
        return
    for past in before:
        same = past is not None and past.stuck_at == sample.stuck_at
        if same and past is not None and past.height is not None and abs(sample.height - past.height) > _APART:
            force = math.hypot(*sample.stuck_at)
            raise IllConditioned(
                f"the force sensor says {force:.4g} N to the last digit at two depths, so that it is stuck; look after it"
            )
