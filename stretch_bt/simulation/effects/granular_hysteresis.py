"""Grains settle under the push: they unload stiffer, and a part of the drop stays."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.balloons.effect import FillEffect
from stretch_bt.simulation.balloons.fills import Seeds
from stretch_bt.simulation.effects.base import Parameters, Size
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response

__all__ = ["GranularHysteresis"]


class GranularHysteresis(FillEffect):
    """Grains settle under the push: they unload stiffer, and a part of the drop stays."""

    name = "granular_hysteresis"
    needs = "compliance"
    order = 3
    cost_ms = 0.02
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield the set that the first press leaves to the next; at the deepest drop so far the force stays as it is."""
        spec = case.scene.object
        if not (isinstance(spec, BalloonObject) and isinstance(spec.fill, Seeds)) or case.scene.conditions.presses == 1:
            return
        left = 1 - 1 / spec.fill.unloading
        yield Size("height", left * cls.drop(case), f"{left:.2g} of the drop stays for the next press")

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the response of grains that settle."""
        from stretch_bt.simulation.balloons.compacting import Compacting

        assert isinstance(spec, BalloonObject)
        assert isinstance(spec.fill, Seeds)
        return None if response is None else Compacting(response, spec.fill.unloading)
