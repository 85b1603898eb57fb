"""Noise that is independent between pixels and frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["WhiteNoise"]


class Parameters(base.Parameters):
    """Its standard deviation, m."""

    sd: Annotated[Length, Within(0.0, 0.1, "Length")] = Field(
        default=5e-5, description="standard deviation of one pixel"
    )
    reference_depth: Annotated[Length, Within(0.01, 10.0, "Length")] | None = Field(
        default=None,
        description="depth at which sd holds where the noise grows with the square of depth; else sd holds everywhere",
    )


class WhiteNoise(CameraEffect):
    """Noise that is independent between pixels and frames."""

    name = "white_noise"
    order = 50
    cost_ms = 0.3
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the noise left after averaging over the pixels of the contact and over frames."""
        from stretch_bt.simulation.camera.averaging import frames_left, noise_sizes

        left = parameters.sd * frames_left(0.0, case.frames)
        yield from noise_sizes(case, left, 0.0, f"{parameters.sd * 1e3:.2g} mm over {case.frames} frames")

    def expose(self, exposure: Exposure) -> None:
        """Add it."""
        if self.parameters.sd > 0:
            from stretch_bt.simulation.camera.added import add
            from stretch_bt.simulation.camera.draws import normal

            noise = normal(exposure.random(self.name), exposure.depth.shape)
            add(exposure, noise, self.parameters.sd, self.parameters.reference_depth)
