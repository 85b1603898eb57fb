"""A limit on the force on the hand, held by the arm or by a force sensor."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.frames import Wrench
from stretch_bt.hardware.ages import FORCE
from stretch_bt.hardware.interfaces import Arm, ForceSensor, Reading
from stretch_bt.hardware.least_force import DEVIATIONS, least_limit
from stretch_bt.tree.context import Context

__all__ = ["ForceLimit"]

#: shortest time over which a noisy arm averages a reading, s
SHORTEST: Final = 0.128


class ForceLimit:
    """The force on the hand, averaged for as long as its limit needs so that noise does not pass it.

    Where the arm's noise is too large for the limit, the tree's force sensor holds the limit, and the arm the least limit that it can hold.

    Parameters
    ----------
    limit
        Largest force, N.
    arm
        The arm that carries the hand.
    sensor
        The force sensor of the tree, where it has one.
    context
        Context of the run.

    Raises
    ------
    IllConditioned
        Nothing can hold the limit.
    """

    def __init__(self, limit: float, arm: Arm, sensor: ForceSensor | None, context: Context) -> None:
        self.limit, self._arm, self._context = limit, arm, context
        noise = arm.force_noise()
        least = least_limit(noise)
        self._sensor = sensor if limit < least else None
        if limit < least and sensor is None:
            raise IllConditioned(
                f"the arm's force is too noisy to hold a limit of {limit:g} N: it can hold {least:.2g} N or more; "
                "declare a force sensor in the tree, or allow more force"
            )
        self._noise = noise
        self._window = (DEVIATIONS * noise / max(limit, least)) ** 2 if noise > 0 else 0.0
        self._held = max(limit, least)
        #: distance to the cell's own limit, N: a force that far below it does not pass it by the noise of single readings
        self.margin = least_limit(noise, SHORTEST)
        self._readings: deque[Reading[Wrench]] = deque()

    def force(self) -> float:
        """Return the magnitude of the force, N."""
        arm = self._of_arm()
        if self._sensor is None:
            return arm
        felt = self._sensor.wrench(FORCE).value.magnitude
        return felt if arm <= max(self._held, self._at_first) else max(arm, felt)

    def reached(self, limit: float | None = None) -> bool:
        """Return whether the force is at a limit, N, or above it, by default at its own; while few readings are averaged, beyond their noise."""
        return not self.force() < self._beyond_noise(self.limit if limit is None else limit)

    def passed(self) -> str | None:
        """Return the reason to stop where the force is above the limit, else None."""
        force = self.force()
        if force <= self._beyond_noise(self.limit):
            return None
        return f"a force of {force:.2f} N exceeds the limit of {self.limit:g} N"

    def _beyond_noise(self, limit: float) -> float:
        return max(limit, self._at_first) if self._sensor is None else limit

    @property
    def latest(self) -> tuple[float, float, float]:
        """The latest force of the arm, N, world axes."""
        return self._readings[-1].value.force

    @property
    def _at_first(self) -> float:
        """The force, N, that noise does not pass while the time to average over has not gone by; else 0."""
        span = self._readings[-1].host_time - self._readings[0].host_time + SHORTEST if self._readings else SHORTEST
        return least_limit(self._noise, span) if span < self._window else 0.0

    def _of_arm(self) -> float:
        reading = self._arm.wrench(FORCE)
        if not self._readings or self._readings[-1].sequence != reading.sequence:
            self._readings.append(reading)
        while len(self._readings) > 1 and self._readings[0].host_time <= reading.host_time - self._window:
            self._readings.popleft()
        return math.hypot(*np.mean([felt.value.force for felt in self._readings], axis=0).tolist())
