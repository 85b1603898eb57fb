"""A smooth error that is the same in all frames of a run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["FixedPattern"]


class Parameters(base.Parameters):
    """Its standard deviation, m, and over how many pixels it is smooth."""

    sd: Annotated[Length, Within(0.0, 0.1, "Length")] = Field(
        default=5e-4, description="standard deviation of the error over cameras"
    )
    kernel: Annotated[float, Within(0.0, 200.0)] = Field(
        default=40.0, description="standard deviation of the Gaussian that smooths it, pixels"
    )


class FixedPattern(CameraEffect):
    """A smooth error that is the same in all frames of a run."""

    name = "fixed_pattern"
    order = 30
    cost_ms = 0.05
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    def __init__(self, parameters: Any) -> None:
        super().__init__(parameters)
        self._pattern: Any = None
        self._pattern_of: Any = None

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield its standard deviation for a height, and the effect of its bend on a size; a drop is the difference of two heights."""
        from stretch_bt.simulation.camera.averaging import noise_sizes

        why = f"{parameters.sd * 1e3:.2g} mm, the same in all frames"
        for size in noise_sizes(case, parameters.sd, parameters.kernel, why):
            if size.observable != "stiffness":
                yield size
            else:
                yield Size("stiffness", _bend(case, parameters), f"{why}; through the radius, as a drop cancels it")

    def expose(self, exposure: Exposure) -> None:
        """Add it."""
        if self.parameters.sd == 0:
            return
        from stretch_bt.simulation.camera.added import add
        from stretch_bt.simulation.camera.fields import SmoothField

        random = exposure.random(self.name, -1)
        run = exposure.depth.shape, int(random.integers(1 << 62))
        if run != self._pattern_of:
            field = SmoothField(exposure.depth.shape, self.parameters.kernel)
            self._pattern, self._pattern_of = field.grow(field.seeds(random)), run
        add(exposure, self._pattern, self.parameters.sd, None)


def _bend(case: Case, parameters: Parameters) -> float:
    """Return half of its relative change of the object's curvature: force goes with the root of the radius."""
    smooth = max(parameters.kernel * case.pixel, 1e-3)
    return min(0.5 * 0.7 * parameters.sd / smooth**2 * case.radius, 1.0)
