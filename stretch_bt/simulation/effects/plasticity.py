"""The dough flows under pressure and stays as it was pressed."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import ObjectEffect, Parameters, Size

__all__ = ["Plasticity"]


class Plasticity(ObjectEffect):
    """The dough flows under pressure and stays as it was pressed; without it a lump is rigid and rolls as it is."""

    name = "plasticity"
    order = 10
    cost_ms = 0.02
    cost_per = "step"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield the depth of a press, of which a rigid lump has none, and how much rolling rounds a cube."""
        from stretch_bt.simulation.dough.estimate import flow

        found = flow(case)
        why = f"F / (Y R^2) {found.group:.2g}"
        yield Size("height", min(found.depth + found.elastic, case.depth), why)
        yield Size("roundness", found.rounding(found.plastic), f"{why}, rolled by {found.turned:.3g} rad")
