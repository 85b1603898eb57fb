"""The filling of a balloon, as the skin feels it: the room that it takes at a pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

__all__ = ["ATMOSPHERE", "Filling", "Gas", "Liquid"]

ATMOSPHERE = 101_325.0  # Pa


class Filling(Protocol):
    """How the room under the cap, m^3, follows from the pressure over the air around, Pa."""

    def room(self, volume: float, inflation: float, pressure: float) -> tuple[float, float]:
        """Return the room at a pressure and its derivative; `volume` is the room at the inflation pressure."""
        ...


@dataclass(frozen=True, slots=True)
class Liquid:
    """Keeps its volume."""

    def room(self, volume: float, inflation: float, pressure: float) -> tuple[float, float]:
        """Return the volume, whatever the pressure."""
        return volume, 0.0


@dataclass(frozen=True, slots=True)
class Gas:
    """An ideal gas; `below` is its volume below the rim, m^3, `exponent` 1 for slow and 1.4 for fast presses of air."""

    below: float = 0.0
    exponent: float = 1.0
    atmosphere: float = ATMOSPHERE

    def room(self, volume: float, inflation: float, pressure: float) -> tuple[float, float]:
        """Return the room by p V^exponent = constant for the gas over and below the rim together."""
        absolute = self.atmosphere + pressure
        grown = math.expm1(math.log1p((inflation - pressure) / absolute) / self.exponent)
        whole = volume + self.below
        return volume + whole * grown, -whole * (1 + grown) / (self.exponent * absolute)
