"""A part of a press comes back when the hand lifts."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import ObjectEffect, Parameters, Size

__all__ = ["Springback"]


class Springback(ObjectEffect):
    """A part of a press comes back when the hand lifts; without it, all of it stays."""

    name = "springback"
    needs = "plasticity"
    order = 11
    cost_ms = 0.0
    cost_per = "step"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield the elastic depth, pi a p / (2 E*) under a punch, and the rounding by rolling that it prevents."""
        from stretch_bt.simulation.dough.estimate import flow

        found = flow(case)
        why = f"elastic part of a press {min(found.elastic / found.depth, 9.99):.2g}"
        yield Size("height", min(found.elastic, case.depth), why)
        yield Size("roundness", found.rounding(1.0) - found.rounding(found.plastic), why)
