"""The object gives way under the hand."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response

__all__ = ["Compliance"]


class Compliance(ObjectEffect):
    """The object gives way under the hand."""

    name = "compliance"
    order = 0
    cost_ms = 0.1
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the drop of membrane and object in series, F / k_o at most the depth; a rigid object has none."""
        k = case.rough.stiffness
        if not math.isfinite(k):
            return
        ratio = case.membrane_stiffness / k
        drop = min(case.force / (k + case.membrane_stiffness), case.depth)
        why = f"membrane over object stiffness {ratio:.2g}"
        yield Size("height", drop, why, way=-1)
        yield Size("force", ratio / (1 + ratio), why, way=-1)
        yield Size("stiffness", 1.0, f"{why}; without it nothing gives way")

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the object's own law."""
        return spec.compliance()
