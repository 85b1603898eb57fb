"""A thin roof between walls that sags, alone or on walls that give way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.buckling import BucklingResponse
from stretch_bt.simulation.objects.response import Law, Response
from stretch_bt.simulation.solve import find_root

__all__ = ["RoofOnWalls", "RoofResponse"]


@dataclass(frozen=True)
class RoofResponse(Response):
    """A force of `linear` w + `cubic` w^3, N, at a sag w, m: bending at first, and tension in the sheet once it has sagged."""

    linear: float
    cubic: float = 0.0

    def __post_init__(self) -> None:
        if not (0 < self.linear < math.inf and 0 <= self.cubic < math.inf):
            raise InvalidInput(
                "a roof needs a finite stiffness above 0 N/m, and one of at least 0 N/m^3 against stretching"
            )

    def force(self, sag: float) -> tuple[float, float]:
        """Return the force, N, and its slope, N/m, at a sag, m."""
        return self.linear * sag + self.cubic * sag**3, self.linear + 3 * self.cubic * sag**2

    def sag(self, force: float) -> float:
        """Return the sag, m, under a force, N: the real root of the cubic, by the hyperbolic sine."""
        if self.cubic == 0:
            return force / self.linear
        p, q = self.linear / self.cubic, force / self.cubic
        scale = 2 * math.sqrt(p / 3)
        return scale * math.sinh(math.asinh(4 * q / scale**3) / 3)

    def law(self, state: Any, dt: float) -> Law:
        """Return its force."""
        return self.force


@dataclass(frozen=True)
class RoofOnWalls(Response):
    """A roof on walls that buckle: both carry the same force, and their drops add up.

    Raises
    ------
    InvalidInput
        The force of the walls falls, so that one drop of the whole belongs to several forces.
    """

    roof: RoofResponse
    walls: BucklingResponse

    def __post_init__(self) -> None:
        if self.walls.fall:
            raise InvalidInput("a roof cannot sag on walls whose force falls; give the walls no fall")

    def force(self, drop: float) -> tuple[float, float]:
        """Return the force, N, and its slope, N/m, at a drop of the roof's middle, m."""
        if drop <= 0:
            slope = 1 / (1 / self.roof.linear + 1 / self.walls.stiffness)
            return slope * drop, slope

        def left(sag: float) -> tuple[float, float]:
            force, slope = self.roof.force(sag)
            given = self.walls.given(force)
            return drop - sag - given, -1 - slope / self.walls.force(given)[1]

        sag = find_root(left, 0.0, drop, drop, "a roof on its walls").x
        force, slope = self.roof.force(sag)
        return force, 1 / (1 / slope + 1 / self.walls.force(self.walls.given(force))[1])

    def law(self, state: Any, dt: float) -> Law:
        """Return its force."""
        return self.force

    def kinks(self, state: Any) -> Sequence[float]:
        """Return the drop at which the walls buckle."""
        return (self.walls.buckled + self.roof.sag(self.walls.critical),)
