"""Pixels at an edge that are seen neither here nor there."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Length, Within

__all__ = ["FlyingPixels"]

_BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))


class Parameters(base.Parameters):
    """Which part of the pixels at an edge fly, from which step of depth on, and how far, m."""

    share: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.001, description="part of the pixels at an edge, 0 to 1"
    )
    step: Annotated[Length, Within(1e-4, 1.0, "Length")] = Field(
        default=5e-3, description="step of depth between neighbours that makes an edge"
    )
    least: Annotated[Length, Within(0.0, 1.0, "Length")] = Field(default=2e-3, description="that they fly")
    most: Annotated[Length, Within(0.0, 1.0, "Length")] = Field(default=1e-2, description="that they fly")


class FlyingPixels(CameraEffect):
    """Pixels at an edge that are seen neither here nor there, but on the way to the other side."""

    name = "flying_pixels"
    order = 20
    cost_ms = 0.3
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
        if self.parameters.share == 0:
            return
        random = exposure.random(self.name)
        drawn = random.random(exposure.depth.shape, np.float32).reshape(-1)
        maybe = np.flatnonzero(drawn < np.float32(self.parameters.share))
        far = random.uniform(self.parameters.least, max(self.parameters.most, self.parameters.least), len(maybe))
        step = _step(exposure.depth, maybe)
        flies = np.abs(step) > self.parameters.step
        moved = np.sign(step) * np.minimum(far, np.abs(step))
        exposure.depth.reshape(-1)[maybe[flies]] += moved[flies].astype(np.float32)


def _step(depth: npt.NDArray[np.float32], places: npt.NDArray[np.intp]) -> Any:
    """Return the largest step, m, from pixels (n,), numbered row by row, to a neighbour that has a value as they have."""
    height, width = depth.shape
    v, u = np.divmod(places, width)
    here, largest = depth[v, u], np.zeros(len(places), np.float32)
    for down, right in _BESIDE:
        there = depth[np.clip(v + down, 0, height - 1), np.clip(u + right, 0, width - 1)]
        step = np.where((here > 0) & (there > 0), there - here, 0)
        largest = np.where(np.abs(step) > np.abs(largest), step, largest)
    return largest
