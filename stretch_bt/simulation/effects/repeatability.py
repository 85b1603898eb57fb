"""Each move ends at a height with a small error."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import RobotEffect, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["Repeatability"]


class Parameters(base.Parameters):
    """Its standard deviation, m."""

    sd: Annotated[Length, Within(0.0, 0.01, "Length")] = Field(
        default=3e-5, description="standard deviation of the height at the end of a move"
    )


class Repeatability(RobotEffect):
    """Each move ends at a height with a small error."""

    name = "repeatability"
    order = 0
    cost_ms = 0.02
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the error of a height, and through the slope of the force the error of a force."""
        yield from case.from_height(parameters.sd, f"{parameters.sd * 1e3:.2g} mm at each move")
        yield Size("force", 1.5 * parameters.sd / case.depth, "through the slope of the force")

    def height_error(self, random: np.random.Generator) -> float:
        """Return one error."""
        return float(random.normal(0.0, self.parameters.sd)) if self.parameters.sd > 0 else 0.0
