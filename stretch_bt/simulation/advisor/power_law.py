"""Closed forms that are fitted to solved sheets: a value at one press, and the power with which it grows with each of its numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["PowerLaw"]


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """Its value `there` over a contact of 10 mm radius at a depth of 10 mm, a strain of 0.4, a coefficient of friction of 0.5 and bends of 2 mm.

    It holds for a contact that is as long towards the clamps as across; `aspect` is the one over the other. The other fields are the
    powers of each of these; the strain's power grows by `wide` where a contact is e times as wide.
    """

    there: float
    depth: float = 0.0
    contact: float = 0.0
    strain: float = 0.0
    friction: float = 0.0
    bend: float = 0.0
    wide: float = 0.0
    aspect: float = 0.0

    def at(
        self,
        *,
        depth: float,
        contact: float,
        strain: float = 0.4,
        friction: float = 0.5,
        bend: float = 2e-3,
        aspect: float = 1.0,
    ) -> float:
        """Return the value; the depth, the radius of the contact and the length of a bend are in m."""
        parts = (
            (depth / 10e-3, self.depth),
            (contact / 10e-3, self.contact),
            (strain / 0.4, self.strain),
            (friction / 0.5, self.friction),
            (bend / 2e-3, self.bend),
            (aspect, self.aspect),
        )
        both = self.wide * math.log(contact / 10e-3) * math.log(strain / 0.4)
        return self.there * math.exp(both + sum(power * math.log(value) for value, power in parts if power))
