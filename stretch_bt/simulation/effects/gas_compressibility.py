"""The gas in a balloon is squeezed by the push, where a liquid keeps its volume."""

from __future__ import annotations

from collections.abc import Iterable

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.balloons.cap import HAND
from stretch_bt.simulation.balloons.effect import FillEffect
from stretch_bt.simulation.balloons.fills import Air
from stretch_bt.simulation.effects.base import Parameters, Size
from stretch_bt.simulation.objects.balloon import BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response

__all__ = ["GasCompressibility"]


class GasCompressibility(FillEffect):
    """The gas in a balloon is squeezed by the push, where a liquid keeps its volume."""

    name = "gas_compressibility"
    needs = "compliance"
    order = 1
    cost_ms = 0.02
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Parameters) -> Iterable[Size]:
        """Yield beta (0.45 + 1.1 / kappa), a fit to the solver's caps at a drop of a twentieth of the radius."""
        spec = case.scene.object
        if not (isinstance(spec, BalloonObject) and isinstance(spec.fill, Air) and spec.pressure > 0):
            return
        beta = spec.fill.softness(spec.radius, spec.pressure)
        part = beta * (0.45 + 1.1 * spec.pressure / (HAND * spec.radius))
        why = f"squeeze of the gas by {beta:.2g} of the cap's volume"
        yield from cls.of_stiffness(case, part, why)

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the response of the gas."""
        from stretch_bt.simulation.balloons.lessened import Lessened

        assert isinstance(spec, BalloonObject)
        return None if response is None else Lessened(response, spec.squeezed())
