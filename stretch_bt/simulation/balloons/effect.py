"""The common part of the effects of balloons."""

from __future__ import annotations

from collections.abc import Iterator

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec

__all__ = ["FillEffect"]


class FillEffect(ObjectEffect):
    """An effect of a balloon's fill; one that its fill does not name is refused."""

    @classmethod
    def refusal(cls, spec: ObjectSpec) -> str | None:
        """Refuse an object without it, and a balloon whose fill has none."""
        refused = super().refusal(spec)
        if refused is not None or not isinstance(spec, BalloonObject) or cls.name in spec.fill.effects:
            return refused
        return f"a balloon filled with {spec.fill.type} has no {cls.name.replace('_', ' ')}"

    @staticmethod
    def drop(case: Case) -> float:
        """Return how far the deepest press lowers the top, m: two springs in series."""
        k, membrane = case.rough.stiffness, case.membrane_stiffness
        return min(case.force / (k + membrane), case.depth)

    @classmethod
    def of_stiffness(cls, case: Case, part: float, why: str) -> Iterator[Size]:
        """Yield the changes of its stiffness, of the drop and of the force in series by a relative change of the object's force."""
        ratio = case.membrane_stiffness / case.rough.stiffness
        yield Size("stiffness", part, why)
        yield Size("height", part * cls.drop(case) / (1 + ratio), why)
        yield Size("force", part * ratio / (1 + ratio), why)
