"""The membrane resists bending as a plate does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stretch_bt.simulation.advisor.case import DROP, Case
from stretch_bt.simulation.advisor.power_law import PowerLaw
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import Holds

__all__ = ["Bending"]

_TOUCH = 1.5e-3  # m, depth of a first touch
_LIFT = 0.6  # lift of the sheet over the slope at the rim times the length of the bend, in solved sheets
_PATCH = 3e-3  # m; a wider tip is seen as it is under a membrane that bends


#: for each shape that holds the membrane up: change of the force as a part of it, of the height over the middle, m, and of a length at four
#: fifths of the depth, m, fitted to solved sheets with and without bending under random bodies (benchmarks/bending.py fit)
_FORCE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.0735, bend=0.94, contact=-0.4, depth=-0.61),
    "crest": PowerLaw(0.073, bend=0.77, contact=-0.68, depth=-0.85),
    "ridge": PowerLaw(0.102, bend=1.24, contact=-0.1, depth=-0.62),
    "dome": PowerLaw(0.0273, bend=0.91, contact=-1.06, depth=-0.42),
    "point": PowerLaw(0.0273, bend=0.91, contact=-1.06, depth=-0.42),
}
_HEIGHT: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.30e-3, bend=1.34, depth=0.73),
    "ridge": PowerLaw(0.107e-3, bend=0.88, depth=1.1),
    "point": PowerLaw(0.023e-3, bend=0.9, contact=-1.5, depth=1.23),
}
#: of a length there are two parts: a long sheet falls off so slowly that a little lift moves its length far, and a slack one lifts far
_SIZE: Mapping[Holds, tuple[PowerLaw, PowerLaw]] = {
    "rim": (
        PowerLaw(1.31e-3, contact=-0.13, depth=-0.23, strain=0.5),
        PowerLaw(0.82e-3, contact=-0.13, depth=-0.23, bend=1.08),
    ),
    "crest": (  # by its own radius
        PowerLaw(0.53e-3, contact=-0.52, depth=-0.54, strain=1.22),
        PowerLaw(2.43e-3, contact=-0.52, depth=-0.54, bend=1.06),
    ),
    "ridge": (PowerLaw(3.31e-3, strain=0.34), PowerLaw(1.47e-3, bend=2.35)),
    "dome": (PowerLaw(0.62e-3, contact=-0.6, strain=0.92), PowerLaw(0.24e-3, contact=-0.6, bend=1.53)),
    "point": (
        PowerLaw(0.55e-3, contact=-0.82, depth=0.32, strain=0.82),
        PowerLaw(0.82e-3, contact=-0.82, depth=0.32, bend=0.99),
    ),
}


class Bending(MembraneEffect):
    """The membrane resists bending as a plate does."""

    name = "bending"
    order = 2
    cost_ms = 3.0
    cost_per = "solve"
    under_one = ("height", "size")
    worth = 0.1  # its error is alike in each press, and no average takes it away

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield the effect of a plate's bending stiffness, 4 mu H^3 / 12, over the length of a bend, the root of stiffness over tension.

        A rim holds the sheet on a line, from which it bends to both sides: it lies off a flat top everywhere else, most where it is
        slack, across the hand, and stands further out. A first touch shows by the shape of the whole sheet, which lies off a ball
        by the slope at the rim times that length; a stiffness, whose drop begins there, depends on it.
        """
        plate = 4 * case.scene.hand.shear_modulus * case.thickness**3 / 12
        layer, holds = math.sqrt(plate / case.tension), case.rough.holds
        contact = case.held_radius
        how, why = (
            {"bend": layer, "contact": contact, "depth": case.depth, "strain": case.taut},
            f"bends within {layer * 1e3:.2g} mm at a contact of {contact * 1e3:.2g} mm",
        )
        yield from case.from_force(_FORCE[holds].at(**how), why, way=1, gives=0.5)
        wide = case.radius if holds == "crest" else contact
        yield Size("size", sum(law.at(**how | {"contact": wide}) for law in _SIZE[holds]), why, way=1)
        if holds in _HEIGHT and (holds != "point" or case.rough.edge < _PATCH):
            yield Size("height", _HEIGHT[holds].at(**how) * case.rough.aspect, f"{why}, and lies off its top", way=1)
        if case.rough.flattens:
            yield Size("height", _HEIGHT["rim"].at(**how), f"{why}, and lies off a top pressed flat", way=1)
        if math.isfinite(case.rough.stiffness):
            off = _LIFT * layer * min(math.sqrt(_TOUCH / (2 * case.radius)), 1.0)
            yield Size(
                "stiffness", off / DROP, f"lifts the sheet by {off * 1e3:.2g} mm at a touch, over a drop of 1.5 mm"
            )

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, bending=True)
