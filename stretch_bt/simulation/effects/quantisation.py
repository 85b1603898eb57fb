"""Rounding of depth to whole counts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length, Within

__all__ = ["Quantisation"]


class Parameters(base.Parameters):
    """The depth of one count, m."""

    unit: Annotated[Length, Within(1e-6, 0.01, "Length")] = Field(default=0.000125, description="one count of depth")


class Quantisation(CameraEffect):
    """Rounding of depth to whole counts."""

    name = "quantisation"
    order = 90
    cost_ms = 0.0
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the standard deviation of rounding where no noise dithers it; with noise it averages out."""
        error = parameters.unit / math.sqrt(12)
        yield from case.from_height(error, f"a count of {parameters.unit * 1e3:.3g} mm over the square root of 12")

    def expose(self, exposure: Exposure) -> None:
        """Make its count that of the frame."""
        exposure.unit = self.parameters.unit
