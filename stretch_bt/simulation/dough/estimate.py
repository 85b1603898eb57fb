"""The effects of a press and of rolling on a lump, in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stretch_bt.simulation.advisor.case import Case
    from stretch_bt.simulation.objects.dough import DoughObject

__all__ = ["CUBE", "Flow", "flow"]

CUBE = 0.125  # standard deviation of a cube's radius over its mean
_FACTOR = 2.2  # mean pressure under a contact of half the radius, over the yield stress
_PART = 0.25
_PATH = 0.7  # between a circle, which rounds a lump little, and a figure-eight
_SPEND = 25.0  # rad of rolling in which most of that is done


@dataclass(frozen=True, slots=True)
class Flow:
    """A press of a rounded lump: its `group` F / (Y R^2), depth and elastic part of it, m, strain rate of rolling, 1/s.

    `plastic` is the part of the depth at a facet's edge, which is met twice as deep, that stays; `turned`, rad, how far
    the lump rolls.
    """

    group: float
    depth: float
    elastic: float
    rate: float
    turned: float

    @property
    def plastic(self) -> float:
        """Part of the depth of a facet's edge that stays."""
        return max(0.0, 1 - self.elastic / (2 * self.depth))

    @property
    def done(self) -> float:
        """Part of the final effect of rolling that is reached by then."""
        return 1 - math.exp(-self.turned / _SPEND)

    def rounding(self, plastic: float) -> float:
        """Return the reduction by rolling of the standard deviation of the radius over its mean."""
        return _PATH * CUBE * plastic * self.done


def flow(case: Case) -> Flow:
    """Return the flow of a scene's dough under its deepest press."""
    spec: DoughObject = case.scene.object  # type: ignore[assignment]
    radius, load = spec.ball, case.force + spec.weight
    contact = min(math.sqrt(load / (_FACTOR * math.pi * spec.yield_stress)), radius)
    elastic = load / (2 * spec.modulus / 0.75 * contact)
    conditions = case.scene.conditions
    return Flow(
        case.force / (spec.yield_stress * radius**2),
        contact**2 / (2 * radius),
        elastic,
        _PART * conditions.speed / (2 * radius),
        conditions.travel / (2 * radius),
    )
