"""Noise of the force sensor."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import RobotEffect, Size
from stretch_bt.units import Force
from stretch_bt.within import Within

__all__ = ["ForceSensorNoise"]

_READINGS = 20  # a fiftieth of a second at 1 kHz


class Parameters(base.Parameters):
    """Its standard deviation, N."""

    sd: Annotated[Force, Within(0.0, 50.0, "Force")] = Field(default=0.02, description="standard deviation per axis")


class ForceSensorNoise(RobotEffect):
    """Noise of the force sensor."""

    name = "force_sensor_noise"
    order = 3
    cost_ms = 0.02
    cost_per = "reading"
    noisy = "ForceSensor"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the noise left in the mean of some readings."""
        left = parameters.sd / math.sqrt(_READINGS) / max(case.force, 1e-9)
        yield Size("force", left, f"{parameters.sd:.2g} N of {case.force:.2g} N, over {_READINGS} readings")

    def force_sd(self, device: str) -> float:
        """Return the standard deviation of the force sensor, N."""
        return float(self.parameters.sd) if device == self.noisy else 0.0
