"""The top of a balloon flattens under the hand."""

from __future__ import annotations

import math
from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.balloons.effect import FillEffect
from stretch_bt.simulation.effects.base import Parameters, Size
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response

__all__ = ["Flattening"]

_FELT_BEFORE = 0.35  # part of the flattening that comes after the press whose fit gives the radius, at half the drop


class Flattening(FillEffect):
    """The top of a balloon flattens under the hand."""

    name = "flattening"
    needs = "compliance"
    order = 5
    cost_ms = 40.0
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield how much wider the top is at 1.5 mm of drop, and the force, which goes as the root of its radius at the drop of a press."""
        spec = case.scene.object
        if not isinstance(spec, BalloonObject) or spec.pressure == 0:
            return
        wider = spec.top_radius(SECANT_DROP)
        part = math.sqrt(wider / spec.radius) - 1
        ratio = case.membrane_stiffness / case.rough.stiffness
        why = f"radius {wider * 1e3:.3g} mm for {spec.radius * 1e3:.3g} mm at a drop of {SECANT_DROP * 1e3:.2g} mm"
        yield Size("size", wider - spec.radius, why)
        pressed = spec.top_radius(min(cls.drop(case), SECANT_DROP))
        yield Size("force", (math.sqrt(pressed / spec.radius) - 1) / (1 + ratio), why, way=1)
        yield Size("height", part * cls.drop(case) / (1 + ratio), why)
        yield Size("stiffness", _FELT_BEFORE * part, f"{why}; the radius is felt at a smaller drop")

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the response as it is: the force of the object is already the force under the hand."""
        return response
