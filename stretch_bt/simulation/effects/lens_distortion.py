"""A lens that bends the sight, which the camera does not tell."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, ClassVar

from pydantic import Field

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import CameraEffect, Size

__all__ = ["LensDistortion"]


class Parameters(base.Parameters):
    """The five coefficients of the inverse Brown-Conrady model: k1, k2, p1, p2, k3."""

    k1: float = Field(default=0.14374, ge=-2, le=2, description="radial, second order")
    k2: float = Field(default=0.04621, ge=-2, le=2, description="radial, fourth order")
    p1: float = Field(default=0.00426, ge=-0.5, le=0.5, description="tangential, along the rows")
    p2: float = Field(default=0.00561, ge=-0.5, le=0.5, description="tangential, along the columns")
    k3: float = Field(default=0.10719, ge=-2, le=2, description="radial, sixth order")


class LensDistortion(CameraEffect):
    """A lens that bends the sight, which the camera does not tell; the coefficients are those of one SR300."""

    name = "lens_distortion"
    order = 0
    cost_ms = 0.5
    cost_per = "frame"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield by how much it makes a contact round the optical axis wider."""
        away = case.radius / (case.pixel * _FOCAL)
        radial = away**2 * (parameters.k1 + away**2 * (parameters.k2 + away**2 * parameters.k3))
        yield Size("size", abs(2 * case.radius * radial), f"{radial:+.2%} at {away:.2f} of the distance from the axis")

    def lens(self, intrinsics: Intrinsics) -> Intrinsics:
        """Return the intrinsics of the lens."""
        given = self.parameters
        return replace(intrinsics, distortion=(given.k1, given.k2, given.p1, given.p2, given.k3))


_FOCAL = 476.0  # pixels, so that a pixel on the membrane times it is the distance
