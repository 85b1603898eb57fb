"""The membrane resists bending as a plate does."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Bending"]


class Bending(MembraneEffect):
    """The membrane resists bending as a plate does."""

    name = "bending"
    order = 2
    cost_ms = 3.0
    cost_per = "solve"

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the edge stiffness of a plate, 4 mu H^3 / 12 over a bend of the contact's size, against the tension.

        Off a crest the sheet bends within sqrt(stiffness / tension), by which it stands further out; on the edges of a wide flat
        top it hardly does.
        """
        plate = 4 * case.scene.hand.shear_modulus * case.thickness**3 / 12
        part = plate / (case.tension * case.contact_radius**2)
        yield from case.from_force(part, f"bending over tension {part:.2g} at the contact")
        layer = math.sqrt(plate / case.tension)
        if not case.rough.face >= case.rough.radius > layer:
            yield Size("size", layer, f"bends within {layer * 1e3:.2g} mm")

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, bending=True)
