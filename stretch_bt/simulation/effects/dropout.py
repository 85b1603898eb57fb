"""Pixels without a value."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.within import Within

__all__ = ["Dropout"]

_STEEP = math.cos(math.radians(60.0))


class Parameters(base.Parameters):
    """The part of the pixels without a value."""

    share: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.01, description="part of the pixels without a value, 0 to 1"
    )
    steep: Annotated[float, Within(1.0, 1000.0)] = Field(
        default=10.0, description="factor on share where the surface is more than 60 deg off the sight"
    )


class Dropout(CameraEffect):
    """Pixels without a value, more of them where the surface is seen at a flat angle."""

    name = "dropout"
    order = 10
    cost_ms = 0.3
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the part of a pixel at the contact's edge that is lost in all frames, and its height on the slope there."""
        share = min(parameters.share, 1.0)
        why = f"{share:.1%} of the pixels, in each of {case.frames} frames"
        lost = case.radius if share >= 1.0 else case.pixel * share**case.frames
        yield Size("size", lost, why)
        yield from case.from_height(lost * case.depth / case.contact_radius, why)

    def expose(self, exposure: Exposure) -> None:
        """Take values away."""
        from stretch_bt.simulation.camera.draws import places
        from stretch_bt.simulation.camera.pixels_kernel import drop

        share, random, lens = self.parameters.share, exposure.random(self.name), exposure.intrinsics
        most = min(share * self.parameters.steep, 1.0)
        maybe = places(random, exposure.depth.size, most)
        drawn = random.random(len(maybe), np.float32)
        drop(exposure.depth, maybe, drawn, share / max(most, 1e-300), lens.fx, lens.fy, lens.cx, lens.cy, _STEEP)
