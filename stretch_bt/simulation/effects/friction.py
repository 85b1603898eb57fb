"""The membrane sticks to the object as far as Coulomb lets it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.power_law import PowerLaw
from stretch_bt.simulation.effects import base
from stretch_bt.simulation.effects.base import MembraneEffect, Size
from stretch_bt.units import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.sheet.effects import Effects as SheetEffects
    from stretch_bt.simulation.objects.base import Holds

__all__ = ["Friction"]

#: over what holds the membrane up: part of the force, m of the height over the middle and m of a length at four fifths of the depth,
#: fitted to sheets solved with friction and without (benchmarks/effect_estimates.py)
_FORCE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.0227, depth=0.85, contact=0.3, strain=0.25, friction=0.65),
    "ridge": PowerLaw(0.0255, depth=0.8, friction=0.5),
    "crest": PowerLaw(0.0199, depth=1.1, friction=0.5),
    "dome": PowerLaw(0.0175, depth=1.25, strain=0.7, friction=0.8),
    "point": PowerLaw(0.0121, depth=0.35, strain=0.45, friction=0.7),
}
_HEIGHT: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.015e-3, depth=1.7, friction=1.0),
    "ridge": PowerLaw(0.006e-3, depth=1.7, friction=1.0),
    "crest": PowerLaw(0.006e-3, depth=1.7, friction=1.0),
    "dome": PowerLaw(0.013e-3, depth=1.7, friction=1.0),
    "point": PowerLaw(0.030e-3, depth=1.7, friction=1.0),
}
_SIZE: Mapping[Holds, PowerLaw] = {
    "rim": PowerLaw(0.60e-3, depth=0.95, contact=-1.2, strain=1.0, friction=0.7),
    "ridge": PowerLaw(0.34e-3, depth=1.3, strain=0.4, friction=0.9),
    "crest": PowerLaw(0.38e-3, depth=1.3, strain=0.4, friction=0.9),
    "dome": PowerLaw(0.70e-3, depth=1.1, strain=0.8, friction=0.8),
    "point": PowerLaw(0.45e-3, depth=1.2, strain=0.5, friction=0.8),
}


class Parameters(base.Parameters):
    """Coulomb's coefficient."""

    coefficient: Annotated[float, Within(0.0, 5.0)] = Field(
        default=0.5, description="0.25 to 0.75 is usual for silicone"
    )


class Friction(MembraneEffect):
    """The membrane sticks to the object as far as Coulomb lets it."""

    name = "friction"
    order = 4
    cost_ms = 50.0
    cost_per = "reading"
    Parameters: ClassVar[type[base.Parameters]] = Parameters

    @classmethod
    def sizes(cls, case: Case, parameters: Any) -> Iterable[Size]:
        """Yield what keeping the sheet from sliding over the body does: it pulls harder, the further it would slide."""
        mu = max(parameters.coefficient, 1e-3)
        why = f"a coefficient of {parameters.coefficient:g} at a strain of {case.strain:.2g}"
        how = {"depth": case.depth, "contact": case.held_radius, "strain": max(case.strain, 1e-3), "friction": mu}
        holds = case.rough.holds
        yield from case.from_force(_FORCE[holds].at(**how), why, way=1)
        yield Size("height", _HEIGHT[holds].at(**how), why)
        yield Size("size", _SIZE[holds].at(**how), why, way=1)

    def on_sheet(self, effects: SheetEffects) -> SheetEffects:
        """Return the sheet's effects with it."""
        return replace(effects, friction=self.parameters.coefficient)
