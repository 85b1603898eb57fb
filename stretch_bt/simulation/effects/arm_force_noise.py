"""Noise of the arm's own estimate of the contact force."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import RobotEffect, Size
from stretch_bt.units import Force
from stretch_bt.within import Within

__all__ = ["ArmForceNoise"]


class Parameters(base.Parameters):
    """Its standard deviation, N."""

    sd: Annotated[Force, Within(0.0, 50.0, "Force")] = Field(default=0.1, description="standard deviation per axis")


class ArmForceNoise(RobotEffect):
    """Noise of the arm's own estimate of the contact force."""

    name = "arm_force_noise"
    order = 2
    cost_ms = 0.02
    cost_per = "reading"
    noisy = "Arm"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield nothing: the arm's force stops a motion, and is no result."""
        return ()

    def force_sd(self, device: str) -> float:
        """Return the standard deviation of the arm's force, N."""
        return float(self.parameters.sd) if device == self.noisy else 0.0
