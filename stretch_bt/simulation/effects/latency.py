"""A device's readings are a little old without its knowledge."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import RobotEffect, Size
from stretch_bt.units import Time
from stretch_bt.within import Within

__all__ = ["Latency"]

_RATE = 30.0  # frames a second: frames exposed before the hand has stopped are seen after it


class Parameters(base.Parameters):
    """Age of the readings, s, by device."""

    camera: Annotated[Time, Within(0.0, 1.0, "Time")] = Field(default=0.05, description="delay of the depth camera")
    force: Annotated[Time, Within(0.0, 1.0, "Time")] = Field(default=0.01, description="delay of arm and force sensor")


class Latency(RobotEffect):
    """A device's readings are a little old without its knowledge."""

    name = "latency"
    order = 1
    cost_ms = 0.02
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the way of the hand in that time, by the share of the averaged frames that show it; across, a height hardly changes."""
        speed, late = case.scene.conditions.speed, parameters.camera
        moved = 0.0 if case.scene.conditions.travel > 0 else speed * late
        moving = min(late * _RATE / (2 * case.frames), 1.0) if case.scene.conditions.hold > 0 else 1.0
        why = f"{speed * 1e3:.3g} mm/s for {late * 1e3:.3g} ms, in {moving:.2g} of the averaged frames"
        yield from case.from_height(moved * moving, why)

    def delay(self, device: str) -> float:
        """Return how old a reading is, s."""
        return float(self.parameters.camera if device == "DepthCamera" else self.parameters.force)
