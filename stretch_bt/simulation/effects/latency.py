"""What a device tells is a little old, and it does not know."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import RobotEffect, Size
from stretch_bt.units import Time, Within

__all__ = ["Latency"]


class Parameters(base.Parameters):
    """How old, s, by device."""

    camera: Annotated[Time, Within(0.0, 1.0, "Time")] = Field(default=0.05, description="of the depth camera")
    force: Annotated[Time, Within(0.0, 1.0, "Time")] = Field(default=0.01, description="of arm and force sensor")


class Latency(RobotEffect):
    """What a device tells is a little old, and it does not know."""

    name = "latency"
    order = 1
    cost_ms = 0.02
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield how far the hand moves in that time while it is read."""
        moved = case.scene.conditions.speed * parameters.camera
        yield from case.from_height(
            moved, f"{case.scene.conditions.speed * 1e3:.3g} mm/s for {parameters.camera * 1e3:.3g} ms"
        )

    def delay(self, device: str) -> float:
        """Return how old a reading is, s."""
        return float(self.parameters.camera if device == "DepthCamera" else self.parameters.force)
