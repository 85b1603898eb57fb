"""Pixels without a value."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Exposure, Size
from stretch_bt.units import Within

__all__ = ["Dropout"]

_STEEP = math.cos(math.radians(60.0))


class Parameters(base.Parameters):
    """The part of the pixels without a value."""

    share: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.01, description="part of the pixels without a value, 0 to 1"
    )
    steep: Annotated[float, Within(1.0, 1000.0)] = Field(
        default=10.0, description="times as many where the surface is more than 60 deg off the sight"
    )


class Dropout(CameraEffect):
    """Pixels without a value, more of them where the surface is seen at a flat angle."""

    name = "dropout"
    order = 10
    cost_ms = 0.4
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield what the lost part of the contact's pixels takes with it: a part of a pixel at its edge."""
        share = min(parameters.share, 1.0)
        why = f"{share:.1%} of the pixels"
        lost = math.inf if share >= 1.0 else case.pixel * share
        yield Size("size", lost, why)
        yield from case.from_height(
            lost * case.depth / case.contact_radius, f"{why}, on the slope of the contact's edge"
        )

    def expose(self, exposure: Exposure) -> None:
        """Take values away."""
        share = self.parameters.share
        if share == 0:
            return
        drawn = exposure.random(self.name).random(exposure.depth.shape, np.float32).reshape(-1)
        maybe = np.flatnonzero(drawn < np.float32(min(share * self.parameters.steep, 1.0)))
        lost = maybe[(drawn[maybe] < np.float32(share)) | _steep(exposure, maybe)]
        exposure.depth.reshape(-1)[lost] = 0.0


def _steep(exposure: Exposure, places: npt.NDArray[np.intp]) -> Any:
    """Return at which pixels (n,), numbered row by row, the surface is more than 60 deg off the sight.

    With n = (fx z_u, fy z_v, -z - (u - cx) z_u - (v - cy) z_v) along the normal of z(u, v) and r the ray at unit depth,
    n . r = -z. Beside a pixel without a value the surface is as level as can be.
    """
    depth, lens = exposure.depth, exposure.intrinsics
    height, width = depth.shape
    v, u = np.divmod(places, width)
    z = depth[v, u]
    across, along = (
        _middle(z, depth[(v, np.maximum(u - 1, 0))], depth[(v, np.minimum(u + 1, width - 1))]),
        _middle(z, depth[(np.maximum(v - 1, 0), u)], depth[(np.minimum(v + 1, height - 1), u)]),
    )
    x, y = u - np.float32(lens.cx), v - np.float32(lens.cy)
    normal = np.sqrt((lens.fx * across) ** 2 + (lens.fy * along) ** 2 + (z + x * across + y * along) ** 2)
    ray = np.sqrt((x / lens.fx) ** 2 + (y / lens.fy) ** 2 + 1)
    return z < _STEEP * normal * ray


def _middle(z: Any, before: Any, after: Any) -> Any:
    """Return the change of depth over a pixel, (n,), from those before and after it, 0 where they have no value."""
    return (np.where(after > 0, after, z) - np.where(before > 0, before, z)) / 2
