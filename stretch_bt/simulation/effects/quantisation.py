"""Rounding of depth to whole counts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["Quantisation"]


class Parameters(base.Parameters):
    """The depth of one count, m; 65,535 of the least reach past a membrane 0.3 m away."""

    unit: Annotated[Length, Within(5e-6, 0.01, "Length")] = Field(default=0.000125, description="depth of one count")


class Quantisation(CameraEffect):
    """Rounding of depth to whole counts."""

    name = "quantisation"
    order = 90
    cost_ms = 0.0
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the error left of rounding: a fixed one where nothing dithers it, else as of white noise.

        Gaussian noise of standard deviation s leaves exp(-2 (pi s / unit)^2) of the fixed error (Widrow and Kollar,
        Quantization Noise, 2008). On a curved top that error comes in rings, the innermost of radius sqrt(radius unit).
        """
        from stretch_bt.simulation.camera.averaging import is_curved, noise_sizes, rim_slope

        unit, noise = parameters.unit, _dither(case)
        rounding, fixed = unit / math.sqrt(12), math.exp(-2 * (math.pi * noise / unit) ** 2)
        why = f"a count of {unit * 1e3:.3g} mm, of which {noise * 1e3:.2g} mm of noise leave {fixed:.0%}"
        level = rounding * fixed  # of a flat face as a whole
        rings = level * min(math.sqrt(case.radius * unit) / case.contact_radius, 1.0)
        white = rounding * math.sqrt(fixed**2 + (1 - fixed**2) / case.frames)
        for size in noise_sizes(case, white, 0.0, why):
            if size.observable == "size":
                yield Size("size", max(size.value, 0.0 if is_curved(case) else 2 * level / rim_slope(case)), why)
            if size.observable == "height":
                yield from case.from_height(max(size.value, rings if is_curved(case) else level), why)

    def expose(self, exposure: Exposure) -> None:
        """Make its count the frame's count."""
        exposure.unit = self.parameters.unit


def _dither(case: Case) -> float:
    """Return the standard deviation, m, of other noise that changes a pixel from frame to frame."""
    from stretch_bt.simulation.effects.correlated_noise import CorrelatedNoise
    from stretch_bt.simulation.effects.white_noise import WhiteNoise

    scene = case.scene
    noises = (effect for effect in (WhiteNoise, CorrelatedNoise) if effect.not_at(scene) is None)
    return math.hypot(*(scene.parameters(effect).sd for effect in noises if scene.choice(effect.name) != "off"))
