"""Noise that neighbouring pixels and successive frames share."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["CorrelatedNoise"]

_FORGOTTEN = 0.01  # weight below which an earlier frame is left out: a ten-thousandth of the variance


class Parameters(base.Parameters):
    """Its standard deviation, m, how many pixels share it, and how much of it stays from frame to frame."""

    sd: Annotated[Length, Within(0.0, 0.1, "Length")] = Field(
        default=3e-4, description="standard deviation of one pixel"
    )
    kernel: Annotated[float, Within(0.0, 200.0)] = Field(
        default=3.0, description="standard deviation of the Gaussian that smooths it, pixels"
    )
    memory: Annotated[float, Within(0.0, 0.95)] = Field(
        default=0.6, description="share of the noise that stays from frame to frame"
    )
    reference_depth: Annotated[Length, Within(0.01, 10.0, "Length")] | None = Field(
        default=None,
        description="depth at which sd holds where the noise grows with the square of depth; else sd holds everywhere",
    )


class CorrelatedNoise(CameraEffect):
    """Noise that neighbouring pixels and successive frames share.

    Each frame is a sum of smooth fields, its own and the ones of the frames before with weights 1, memory, memory^2 ...:
    an autoregressive process of first order, cut off where it has forgotten, so that a frame does not depend on which frames
    were looked at before it.
    """

    name = "correlated_noise"
    order = 40
    cost_ms = 0.75
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    def __init__(self, parameters: Any) -> None:
        super().__init__(parameters)
        self._kept: dict[int, Any] = {}
        self._kept_of: Any = None

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the noise left after averaging over groups of pixels and over frames."""
        from stretch_bt.simulation.camera.averaging import frames_left, noise_sizes

        left = parameters.sd * frames_left(parameters.memory, case.frames)
        why = f"{parameters.sd * 1e3:.2g} mm over {case.frames} frames of memory {parameters.memory:g}"
        yield from noise_sizes(case, left, parameters.kernel, why)

    def expose(self, exposure: Exposure) -> None:
        """Add it."""
        given = self.parameters
        if given.sd == 0:
            return
        from stretch_bt.simulation.camera.added import add
        from stretch_bt.simulation.camera.fields import SmoothField

        field = SmoothField(exposure.depth.shape, given.kernel)
        add(exposure, field.grow(self._seeds(exposure, field)), given.sd, given.reference_depth)

    def _seeds(self, exposure: Exposure, field: Any) -> Any:
        """Return the weighted sum of the seeds of the fields of this frame and of the frames before it."""
        run = exposure.depth.shape, int(exposure.random(self.name, -1).integers(1 << 62))
        if run != self._kept_of:
            self._kept, self._kept_of = {}, run
        weights = _weights(self.parameters.memory)
        numbers = range(exposure.number, exposure.number - len(weights), -1)
        self._kept = {
            n: self._kept[n] if n in self._kept else field.seeds(exposure.random(self.name, _before(n)))
            for n in numbers
        }
        total = weights[0] * self._kept[exposure.number]
        for weight, number in zip(weights[1:], numbers[1:], strict=True):
            total += weight * self._kept[number]
        return total


def _weights(memory: float) -> Any:
    """Return the weights of this frame and of the frames before it; their squares add up to 1."""
    count = 1 if memory == 0 else max(math.ceil(math.log(_FORGOTTEN) / math.log(memory)), 1)
    weights = memory ** np.arange(count)
    return (weights / np.sqrt((weights**2).sum())).astype(np.float32)


def _before(number: int) -> int:
    """Return the number of a frame's noise source: frames before the first count back from -2, as -1 is the whole run's."""
    return number if number >= 0 else number - 1
