"""The membrane resists bending as a plate does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from stretch_bt.simulation.advisor.case import DROP, GAUGE, Case
from stretch_bt.simulation.effects.base import MembraneEffect, Size

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import Holds

__all__ = ["Bending", "contact_of"]

_TOUCH = 1.5e-3  # m, of a first touch
_LIFT = 0.6  # of the slope at the rim times the length of the bend, as solved sheets have it
_BEND, _ACROSS, _DEEP = (
    2e-3,
    10e-3,
    10e-3,
)  # m: length of a bend, radius of a contact and depth that the laws are told at
_PATCH = 3e-3  # m; a wider tip is seen as it is under a membrane that bends
_ROUNDS = 20


class _Law(NamedTuple):
    """What a bend of 2 mm, a contact of 10 mm and a depth of 10 mm make, and the powers of each."""

    there: float
    bend: float
    contact: float
    depth: float

    def at(self, bend: float, contact: float, depth: float) -> float:
        parts = ((bend / _BEND, self.bend), (contact / _ACROSS, self.contact), (depth / _DEEP, self.depth))
        return self.there * math.exp(sum(power * math.log(value) for value, power in parts))


#: over what holds the membrane up: part of the force, m of the height over the middle, and m of a length at four fifths of the depth,
#: fitted to solved sheets with and without bending under random bodies (benchmarks/bending.py fit)
_FORCE: Mapping[Holds, _Law] = {
    "rim": _Law(0.0735, 0.94, -0.40, -0.61),
    "crest": _Law(0.073, 0.77, -0.68, -0.85),
    "ridge": _Law(0.102, 1.24, -0.10, -0.62),
    "dome": _Law(0.0273, 0.91, -1.06, -0.42),
    "point": _Law(0.0273, 0.91, -1.06, -0.42),
}
_HEIGHT: Mapping[Holds, _Law] = {
    "rim": _Law(0.30e-3, 1.34, 0.0, 0.73),
    "ridge": _Law(0.107e-3, 0.88, 0.0, 1.10),
    "point": _Law(0.023e-3, 0.90, -1.50, 1.23),
}
_SIZE: Mapping[Holds, _Law] = {
    "rim": _Law(1.65e-3, 0.0, 0.0, 0.0),
    "crest": _Law(3.94e-3, 1.00, -1.00, -0.40),  # by its own radius
    "ridge": _Law(4.26e-3, 0.0, 0.0, 0.0),
    "dome": _Law(0.61e-3, 0.0, -0.95, 0.0),
    "point": _Law(1.08e-3, 0.0, -0.84, 0.0),
}


class Bending(MembraneEffect):
    """The membrane resists bending as a plate does."""

    name = "bending"
    order = 2
    cost_ms = 3.0
    cost_per = "solve"
    worth = 0.1  # what it moves, it moves alike in each press, and no average takes it away

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield what the edge stiffness of a plate, 4 mu H^3 / 12, does over the length of a bend, the root of it over the tension.

        A rim holds the sheet on a line, from which it bends to both sides: it lies off a flat top everywhere else, most where it is
        slack, across the hand, and stands further out. A first touch is told by the shape of all of the sheet, which lies off a ball
        by the slope at the rim over that bend; a stiffness, whose drop begins there, hangs on it.
        """
        plate = 4 * case.scene.hand.shear_modulus * case.thickness**3 / 12
        layer, holds = math.sqrt(plate / case.tension), case.rough.holds
        contact = contact_of(case)
        at, why = (
            (layer, contact, case.depth),
            f"bends within {layer * 1e3:.2g} mm at a contact of {contact * 1e3:.2g} mm",
        )
        yield from case.from_force(_FORCE[holds].at(*at), why)
        wide = case.radius if holds == "crest" else contact
        yield Size("size", _SIZE[holds].at(layer, wide, case.depth), why)
        if holds in _HEIGHT and (holds != "point" or case.rough.edge < _PATCH):
            yield Size("height", _HEIGHT[holds].at(*at) * case.rough.aspect, f"{why}, and lies off its top")
        if math.isfinite(case.rough.stiffness):
            off = _LIFT * layer * min(math.sqrt(_TOUCH / (2 * case.radius)), 1.0)
            yield Size(
                "stiffness", off / DROP, f"lifts the sheet by {off * 1e3:.2g} mm at a touch, over a drop of 1.5 mm"
            )

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, bending=True)


def contact_of(case: Case) -> float:
    """Return the radius of the contact, m; over a point that up to which a taut sheet lies on its tip, or on its flanks."""
    rough = case.rough
    if rough.holds not in ("dome", "point"):
        return case.contact_radius
    tip = case.radius if rough.holds == "dome" else rough.edge
    radius = _ACROSS
    for _ in range(_ROUNDS):
        fall = case.depth / 2 / math.log(GAUGE / 2 / min(radius, GAUGE / 4))
        radius = max(math.sqrt(tip * fall), fall / rough.steep)
    return radius
