"""The thin roof of an object sags under the membrane."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import ObjectEffect, Size
from stretch_bt.simulation.objects.base import ObjectSpec
from stretch_bt.simulation.objects.buckling import BucklingResponse
from stretch_bt.simulation.objects.paper import PaperSpec
from stretch_bt.simulation.objects.response import Response
from stretch_bt.simulation.objects.roof import RoofOnWalls
from stretch_bt.within import Within

__all__ = ["RoofSag"]


class Parameters(base.Parameters):
    """Share of the force that the roof bears between its edges, assumed."""

    share: Annotated[float, Within(1e-3, 1.0)] = Field(default=0.25, description="share of the force, over the roof")


class RoofSag(ObjectEffect):
    """The thin roof of an object sags under the membrane.

    The top goes down as a whole by the sag of its middle: the folds at its edges turn and follow.
    """

    name = "roof_sag"
    order = 10
    cost_ms = 0.1
    cost_per = "solve"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the sag under the force of the deepest press, and its reduction of that force."""
        spec = case.scene.object
        if not isinstance(spec, PaperSpec):
            return
        roof = spec.roof(parameters.share)
        # the sag takes its part of the depth, and with it of the force, which goes as depth^1.5
        sag = min(roof.sag(case.force), case.depth)
        sag = roof.sag(case.force * max(1 - sag / case.depth, 0.0) ** 1.5) / 2 + sag / 2
        why = f"{case.force:.2g} N, {parameters.share:.0%} of it over the roof"
        yield Size("height", sag, why)
        yield Size("force", min(1.5 * sag / case.depth, 1.0), why)

    def respond(self, response: Response | None, spec: ObjectSpec) -> Response | None:
        """Return the roof on walls that give way, or on rigid ones."""
        assert isinstance(spec, PaperSpec)
        roof = spec.roof(self.parameters.share)
        if response is None:
            return roof
        assert isinstance(response, BucklingResponse)
        return RoofOnWalls(roof, response)
