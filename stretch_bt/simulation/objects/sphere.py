"""A sphere, fixed where it stands, that keeps its shape and gives way as a whole."""

from __future__ import annotations

from typing import Literal

from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.round import RoundSpec
from stretch_bt.simulation.objects.solid import SolidSpec

__all__ = ["SphereObject"]


class SphereObject(RoundSpec, SolidSpec):
    """A sphere, fixed where it stands."""

    type: Literal["sphere"]

    def rough(self) -> Rough:
        """Return its radius and stiffness."""
        return Rough(self.diameter / 2, self.roughly, edge=self.diameter / 2)

    def known(self) -> dict[str, float]:
        """Return its radius, m, and its stiffness, N/m."""
        return {"radius": self.diameter / 2, **super().known()}
