"""Pixels at an edge whose depth lies between its two sides."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["FlyingPixels"]


class Parameters(base.Parameters):
    """The part of the pixels at an edge that fly, the step of depth that makes an edge, and how far they fly, m."""

    share: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.001, description="part of the pixels at an edge that fly, 0 to 1"
    )
    step: Annotated[Length, Within(1e-4, 1.0, "Length")] = Field(
        default=5e-3, description="step of depth between neighbours that makes an edge"
    )
    least: Annotated[Length, Within(0.0, 1.0, "Length")] = Field(default=2e-3, description="least distance flown")
    most: Annotated[Length, Within(0.0, 1.0, "Length")] = Field(default=1e-2, description="largest distance flown")


class FlyingPixels(CameraEffect):
    """Pixels at an edge whose depth lies between its two sides, on the way to the other one."""

    name = "flying_pixels"
    order = 20
    cost_ms = 0.06
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield their mean over the pixels of an edge, at an object that reaches the free sides of the membrane."""
        width = 2 * case.radius
        mean = parameters.share * (parameters.least + parameters.most) / 2
        reaches = width >= 0.085  # within a few millimetres of the sides of a membrane of 90 mm, where the edges are
        yield Size("size", mean if reaches else 0.0, f"the contact is {width * 1e3:.0f} mm wide, edges are at 90 mm")

    def expose(self, exposure: Exposure) -> None:
        """Let some fly."""
        from stretch_bt.simulation.camera.draws import places
        from stretch_bt.simulation.camera.pixels_kernel import fly

        given, random = self.parameters, exposure.random(self.name)
        maybe = places(random, exposure.depth.size, given.share)
        far = random.uniform(given.least, max(given.most, given.least), len(maybe))
        fly(exposure.depth, maybe, far, given.step)
