"""The lump turns about the vertical by chance while it rolls."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.within import Within

__all__ = ["SpinNoise"]

_MOST, _HALF = 0.04, 3.0  # largest change of roundness; spin, rad, at which half of it is reached; for a circular path


class Parameters(base.Parameters):
    """Standard deviation of the turn, rad per square root of a rad of rolling."""

    sd: Annotated[float, Within(0.0, 5.0)] = Field(
        default=0.05, description="turn after one rad of rolling, rad; it grows with the root of that"
    )


class SpinNoise(ObjectEffect):
    """The lump turns about the vertical by chance while it rolls, which brings new places under the hand."""

    name = "spin_noise"
    order = 15
    cost_ms = 0.001
    cost_per = "step"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield how much rounder a circular path makes the lump; a figure-eight hardly needs it."""
        from stretch_bt.simulation.dough.estimate import flow

        spun = parameters.sd * math.sqrt(flow(case).turned)
        yield Size("roundness", _MOST * spun / (spun + _HALF), f"it turns by {spun:.2g} rad in all")
