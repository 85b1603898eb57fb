"""The dough flows at a higher stress when it is deformed fast."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.units import Pressure
from stretch_bt.within import Within

__all__ = ["DoughViscosity"]

_SENSITIVITY = 0.1  # change of roundness for a yield stress e times as high, after 1 to 2 m of rolling


class Parameters(base.Parameters):
    """The law of Herschel and Bulkley: the yield stress rises by `thickening` x (rate in 1/s)^`power`."""

    thickening: Annotated[Pressure, Within(0.0, 1e6, "Pressure")] = Field(
        default=500.0, description="rise of the yield stress at a strain rate of 1/s"
    )
    power: Annotated[float, Within(0.05, 1.0)] = Field(default=0.4, description="exponent, 0.3 to 0.5 for most pastes")


class DoughViscosity(ObjectEffect):
    """The dough flows at a higher stress when it is deformed fast."""

    name = "dough_viscosity"
    needs = "plasticity"
    order = 12
    cost_ms = 0.1
    cost_per = "step"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the changes of a press' depth and of the rounding by a yield stress higher by that part."""
        from stretch_bt.simulation.dough.estimate import flow

        found = flow(case)
        part = parameters.thickening * found.rate**parameters.power / case.scene.object.yield_stress  # type: ignore[attr-defined]
        why = f"yield stress higher by {part:.2g} of it at {found.rate:.2g}/s"
        yield Size("height", found.depth * part / (1 + part), why)
        yield Size("roundness", _SENSITIVITY * math.log1p(part) * found.done, why)
