"""Depth that grows or shrinks slowly as the camera warms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Speed
from stretch_bt.within import Within

__all__ = ["Drift"]


class Parameters(base.Parameters):
    """Its rate, m/s."""

    rate: Annotated[Speed, Within(0.0, 1e-3, "Speed")] = Field(
        default=2e-4 / 60, description="rate of change of depth; each run has a sign of its own"
    )


class Drift(CameraEffect):
    """Depth that grows or shrinks slowly as the camera warms: evenly from the begin of a run, with a sign drawn for each."""

    name = "drift"
    order = 35
    cost_ms = 0.05
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the change of depth during the presses: down, hold, and up again."""
        conditions = case.scene.conditions
        moving = 2 * case.depth / conditions.speed if conditions.speed > 0 else 0.0
        lasting = conditions.presses * (conditions.hold + moving)
        why = f"{parameters.rate * 6e4:.2g} mm/min for {lasting:.3g} s"
        yield from case.from_height(parameters.rate * lasting, why)

    def expose(self, exposure: Exposure) -> None:
        """Add it."""
        from stretch_bt.simulation.camera.added import add

        sign = 1.0 if exposure.random(self.name, -1).random() < 0.5 else -1.0
        add(exposure, np.ones(exposure.depth.shape, np.float32), sign * self.parameters.rate * exposure.time, None)
