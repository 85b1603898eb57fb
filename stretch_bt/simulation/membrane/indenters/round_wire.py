"""The common part of bodies bent from round wire."""

from __future__ import annotations

from stretch_bt.simulation.membrane.indenters.base import Solid

__all__ = ["RoundWire"]


class RoundWire(Solid):
    """A body of round wire of a `diameter`, m."""

    __slots__ = ()
    diameter: float

    @property
    def feature(self) -> float:
        """Radius of the wire, m."""
        return self.diameter / 2

    @property
    def bulk(self) -> float:
        """Thickness of the wire, m."""
        return self.diameter
