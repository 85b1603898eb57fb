"""The latex of a balloon is softer up to where it has been pressed before."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.balloons.effect import FillEffect
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import Size
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.response import Response
from stretch_bt.within import Within

__all__ = ["LatexSoftening"]


class Parameters(base.Parameters):
    """Its loss of force."""

    share: Annotated[float, Field(gt=0.0, lt=1.0), Within()] = Field(
        default=0.1, description="share of the skin's force that is lost where a second press begins"
    )


class LatexSoftening(FillEffect):
    """The latex of a balloon is softer up to where it has been pressed before."""

    name = "latex_softening"
    needs = "compliance"
    order = 2
    cost_ms = 0.02
    cost_per = "solve"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield share / presses: of presses that deepen evenly the last is that part short of the one before it, or nothing."""
        spec, presses = case.scene.object, case.scene.conditions.presses
        if not isinstance(spec, BalloonObject) or spec.tabulated is None or presses == 1:
            return
        carried = spec.skin(SECANT_DROP)[0] / spec.law(SECANT_DROP)[0]
        part = parameters.share * carried / presses
        yield from cls.of_stiffness(case, part, f"{presses} presses, each deeper than the one before")

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the response with a skin that softens."""
        from stretch_bt.simulation.balloons.softened import Softened

        assert isinstance(spec, BalloonObject)
        return None if response is None else Softened(response, spec.skin, self.parameters.share)
