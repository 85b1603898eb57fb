"""Rounding of depth to whole counts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length, Within

__all__ = ["Quantisation"]


class Parameters(base.Parameters):
    """The depth of one count, m."""

    unit: Annotated[Length, Within(1e-6, 0.01, "Length")] = Field(default=0.000125, description="one count of depth")


class Quantisation(CameraEffect):
    """Rounding of depth to whole counts."""

    name = "quantisation"
    order = 90
    cost_ms = 0.0
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield what is left of rounding: as of white noise where noise or a slope dithers it, else all of it.

        Gaussian noise of standard deviation s leaves a bias of at most unit / pi exp(-2 (pi s / unit)^2) (Widrow and Kollar,
        Quantization Noise, 2008).
        """
        from stretch_bt.simulation.camera.averaging import noise_sizes

        unit = parameters.unit
        rounding, noise = unit / math.sqrt(12), _dither(case)
        flat = case.rough.edge < case.radius / 2 or case.depth < unit
        bias = unit / math.pi * math.exp(-2 * (math.pi * noise / unit) ** 2) / math.sqrt(2) if flat else 0.0
        why = f"a count of {unit * 1e3:.3g} mm, {noise * 1e3:.2g} mm of noise dithers it"
        yield from noise_sizes(case, rounding / math.sqrt(case.frames), 0.0, why)
        if bias > 0:
            yield from case.from_height(bias, f"{why} on a flat face")

    def expose(self, exposure: Exposure) -> None:
        """Make its count that of the frame."""
        exposure.unit = self.parameters.unit


def _dither(case: Case) -> float:
    """Return the standard deviation, m, of what else changes a pixel from frame to frame."""
    from stretch_bt.simulation.effects.correlated_noise import CorrelatedNoise
    from stretch_bt.simulation.effects.white_noise import WhiteNoise

    scene = case.scene
    noises = (effect for effect in (WhiteNoise, CorrelatedNoise) if effect.not_at(scene) is None)
    return math.hypot(*(scene.parameters(effect).sd for effect in noises if scene.choice(effect.name) != "off"))
