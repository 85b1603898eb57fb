"""Noise that is independent between pixels and frames."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length, Within

__all__ = ["WhiteNoise"]


class Parameters(base.Parameters):
    """Its standard deviation, m."""

    sd: Annotated[Length, Within(0.0, 0.1, "Length")] = Field(
        default=5e-5, description="standard deviation of one pixel"
    )


class WhiteNoise(CameraEffect):
    """Noise that is independent between pixels and frames."""

    name = "white_noise"
    order = 40
    cost_ms = 0.6
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield what is left of it after averaging over the pixels of the contact and over frames."""
        count = max(case.contact_pixels, 1.0) * case.frames
        left = parameters.sd / math.sqrt(count)
        yield from case.from_height(left, f"{parameters.sd * 1e3:.2g} mm over {count:.0f} pixels")

    def expose(self, exposure: Exposure) -> None:
        """Add it."""
        if self.parameters.sd > 0:
            noise = exposure.random(self.name).standard_normal(exposure.depth.shape, np.float32)
            exposure.depth += noise * np.float32(self.parameters.sd) * (exposure.depth > 0)
