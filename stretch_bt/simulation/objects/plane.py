"""A block with a flat, level top that is wider than the membrane."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from stretch_bt.simulation.objects.base import HertzForm, Rough
from stretch_bt.simulation.objects.solid import SolidSpec
from stretch_bt.units import Length
from stretch_bt.within import Within

__all__ = ["PlaneObject"]


class PlaneObject(SolidSpec):
    """A block with a flat, level top that is wider than the membrane; at `hertz` fidelity only.

    Its force equals the force of a flat-ended cylinder of 80 mm, about as wide as the membrane.
    """

    type: Literal["plane"]
    height: Annotated[Length, Within(0.001, 0.5, "Length")]

    @property
    def top(self) -> float:
        """World height of its top, m."""
        return self.base + self.height

    @property
    def reach(self) -> float:
        """Without end."""
        return math.inf

    @property
    def hertz(self) -> HertzForm:
        """A plane."""
        return HertzForm("plane", 0.040)

    def body(self) -> None:
        """Return None: it meets the fingers, and no membrane spans it."""
        return

    def rough(self) -> Rough:
        """Return its stiffness."""
        return Rough(math.inf, self.roughly)
