"""The edge of a pressed disc cracks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.simulation.scene.sections import Fraction
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["EdgeCracks"]


class Parameters(base.Parameters):
    """Roughness of the outline over its radius, and its correlation length, m."""

    roughness: Annotated[float, Fraction(), Within(0.0, 0.2)] = Field(
        default=0.015, description="relative sd of the outline's radius, pressed to a third of the height"
    )
    correlation: Annotated[Length, Within(1e-4, 0.05, "Length")] = Field(
        default=3e-3, description="correlation length of the cracks along the outline"
    )


class EdgeCracks(ObjectEffect):
    """The edge of a pressed disc cracks, in proportion to how far it was pressed; a lump that rolls has none."""

    name = "edge_cracks"
    needs = "plasticity"
    order = 14
    cost_ms = 0.05
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the roughness that the deepest press leaves, on an outline that is round without it."""
        from stretch_bt.simulation.dough.estimate import flow

        spec = case.scene.object
        lost = min(max(flow(case).depth - flow(case).elastic, 0.0) / spec.edge, 1.0)  # type: ignore[attr-defined]
        strain = 1.0 if lost > 1.0 - math.exp(-1.0) else -math.log1p(-lost)
        yield Size("roundness", parameters.roughness * strain, f"a press takes {lost:.2g} of the height for good")
