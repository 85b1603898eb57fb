"""The membrane resists bending as a plate does."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import DROP, Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects

__all__ = ["Bending"]

_TOUCH = 1.5e-3  # m, of a first touch
_LIFT = 0.6  # of the slope at the rim times the length of the bend, as solved sheets have it


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
        top it hardly does. A first touch is told by the shape of all of the sheet, which lies off a ball by the slope at the rim over that
        bend; a stiffness, whose drop begins there, hangs on it.
        """
        plate = 4 * case.scene.hand.shear_modulus * case.thickness**3 / 12
        part = plate / (case.tension * case.contact_radius**2)
        yield from case.from_force(part, f"bending over tension {part:.2g} at the contact")
        layer = math.sqrt(plate / case.tension)
        if not case.rough.face >= case.rough.radius > layer:
            yield Size("size", layer, f"bends within {layer * 1e3:.2g} mm")
        if math.isfinite(case.rough.stiffness):
            off = _LIFT * layer * min(math.sqrt(_TOUCH / (2 * case.radius)), 1.0)
            yield Size(
                "stiffness", off / DROP, f"lifts the sheet by {off * 1e3:.2g} mm at a touch, over a drop of 1.5 mm"
            )

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, bending=True)
