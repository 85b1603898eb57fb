"""Pixels without a value."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Within

__all__ = ["Dropout"]


class Parameters(base.Parameters):
    """The part of the pixels without a value."""

    share: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.01, description="part of the pixels without a value, 0 to 1"
    )


class Dropout(CameraEffect):
    """Pixels without a value."""

    name = "dropout"
    order = 80
    cost_ms = 0.4
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the part of the contact's area that is lost, as a length of its edge."""
        yield Size("size", parameters.share * case.pixel, f"{parameters.share:.1%} of a pixel at the contact's edge")

    def expose(self, exposure: Exposure) -> None:
        """Take values away."""
        if self.parameters.share > 0:
            lost = exposure.random(self.name).random(exposure.depth.shape, np.float32) < self.parameters.share
            exposure.depth[lost] = 0.0
