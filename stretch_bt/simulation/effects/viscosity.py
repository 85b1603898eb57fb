"""A gel resists a fast push, and relaxes with time."""

from __future__ import annotations

import math
from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.balloons.effect import FillEffect
from stretch_bt.simulation.effects.base import Parameters, Size
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response
from stretch_bt.simulation.objects.soft_sphere import SoftSphereObject

__all__ = ["Viscosity"]


class Viscosity(FillEffect):
    """A gel resists a fast push, and relaxes with time."""

    name = "viscosity"
    needs = "compliance"
    order = 4
    cost_ms = 0.05
    cost_per = "step"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield the rest of the sudden force, over the relaxed force, after a press at even speed and the hold."""
        spec = case.scene.object
        gel = spec.gel() if isinstance(spec, BalloonObject | SoftSphereObject) else None
        if not isinstance(spec, BalloonObject | SoftSphereObject) or gel is None:
            return
        branch, time = gel
        conditions = case.scene.conditions
        press = case.depth / conditions.speed / time if conditions.speed > 0 else math.inf
        left = (-math.expm1(-press) / press if press > 0 else 1.0) * math.exp(-conditions.hold / time)
        part = left * branch(SECANT_DROP)[0] / spec.law(SECANT_DROP)[0]
        yield from cls.of_stiffness(case, part, f"{left:.2g} of the sudden force is left when it is read")

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the response with a gel that relaxes beside it."""
        from stretch_bt.simulation.balloons.relaxing import Relaxing

        assert isinstance(spec, BalloonObject | SoftSphereObject)
        gel = spec.gel()
        return response if response is None or gel is None else Relaxing(response, *gel)
