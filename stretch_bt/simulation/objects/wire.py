"""The common part of wires bent to a closed shape: they lie flat on the table, loose, and do not give way."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated, ClassVar

from pydantic import Field

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.loose import LooseSpec
from stretch_bt.units import Force, Length
from stretch_bt.within import Within

__all__ = ["WireSpec"]

_STEEL = 7850.0  # kg/m^3
_GRAVITY = 9.81


class WireSpec(LooseSpec, ABC):
    """Options of a round wire, bent to a closed shape that lies flat."""

    effects: ClassVar[tuple[str, ...]] = ("rigid_shift",)

    thickness: Annotated[Length, Within(0.0003, 0.010, "Length")] = Field(
        default=0.002, description="diameter of the wire"
    )
    weight: Annotated[Force, Within(0.0, 100.0, "Force")] | None = Field(
        default=None, description="weight; by default of steel"
    )

    @property
    @abstractmethod
    def around(self) -> float:
        """Length of the wire, m."""

    @property
    def own_weight(self) -> float:
        """Its weight, N."""
        steel = _STEEL * _GRAVITY * math.pi * self.thickness**2 / 4 * self.around
        return steel if self.weight is None else self.weight

    @property
    def top(self) -> float:
        """World height of its upper side, m."""
        return self.base + self.thickness

    def rough(self) -> Rough:
        """Return the radius of the wire, its span and its weight."""
        half = self.thickness / 2
        return Rough(half, weight=self.own_weight, edge=half, loose=True, face=self.reach, holds="rim")
