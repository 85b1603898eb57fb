"""A lens that distorts the image, which the camera does not report."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Size
from stretch_bt.within import Within

__all__ = ["LensDistortion"]


_Radial = Annotated[float, Within(-2.0, 2.0)]
_Tangential = Annotated[float, Within(-0.5, 0.5)]


class Parameters(base.Parameters):
    """The five coefficients of the inverse Brown-Conrady model: k1, k2, p1, p2, k3."""

    k1: _Radial = Field(default=0.14374, description="radial coefficient, second order")
    k2: _Radial = Field(default=0.04621, description="radial coefficient, fourth order")
    p1: _Tangential = Field(default=0.00426, description="tangential coefficient, along the rows")
    p2: _Tangential = Field(default=0.00561, description="tangential coefficient, along the columns")
    k3: _Radial = Field(default=0.10719, description="radial coefficient, sixth order")


class LensDistortion(CameraEffect):
    """A lens that distorts the image, which the camera does not report; the coefficients are of one SR300."""

    name = "lens_distortion"
    order = 0
    cost_ms = 0.5
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield its widening of a contact around the optical axis."""
        away = case.radius / (case.pixel * _FOCAL)
        radial = away**2 * (parameters.k1 + away**2 * (parameters.k2 + away**2 * parameters.k3))
        yield Size("size", abs(2 * case.radius * radial), f"{radial:+.2%} at {away:.2f} of the distance from the axis")

    def lens(self, intrinsics: Intrinsics) -> Intrinsics:
        """Return the intrinsics of the lens."""
        given = self.parameters
        return replace(intrinsics, distortion=(given.k1, given.k2, given.p1, given.p2, given.k3))


_FOCAL = 476.0  # pixels, so that a pixel on the membrane times it is the distance
