"""The sheet solver on a circular membrane: any indenter, anywhere, where the axisymmetric solver takes a centred sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.materials import Material
from stretch_bt.simulation.membrane.sheet.disc import Disc
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings

if TYPE_CHECKING:  # numba comes along with it
    from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["RoundSheet"]


@dataclass(frozen=True, slots=True)
class RoundSheet:
    """A membrane of undeformed `thickness`, m, clamped at `radius`, m, after an even stretch by `prestretch`.

    The same membrane as CircularMembrane, solved as a surface. It has the sheet's effects but for bending and friction.
    """

    radius: float
    thickness: float
    material: Material
    prestretch: float = 1.0
    effects: Effects = field(default_factory=Effects)

    def __post_init__(self) -> None:
        for name in ("radius", "thickness"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InvalidInput(f"the {name} of a round sheet must be a finite length above 0 m, not {value!r}")
        if not (math.isfinite(self.prestretch) and self.prestretch >= 1):
            raise InvalidInput(f"the prestretch must be a finite number of at least 1, not {self.prestretch!r}")
        if self.effects.bending or self.effects.friction:
            raise InvalidInput("a round sheet takes no bending and no friction; a rectangular one does")

    @property
    def sheet(self) -> Sheet:
        """The sheet that is solved; its gauge is the undeformed diameter."""
        gauge = 2 * self.radius / self.prestretch
        pulled = 2 * self.radius - gauge
        return Sheet(gauge, gauge, self.thickness, self.material, pulled, self.effects, Disc())

    def press(
        self,
        indenter: Indenter | Several,
        depth: float,
        *,
        at: tuple[float, float] = (0.0, 0.0),
        tilt: tuple[float, float] = (0.0, 0.0),
        settings: Settings | None = None,
        start: SheetPress | None = None,
    ) -> SheetPress:
        """Return the equilibrium under an indenter pressed `depth`, m, past the flat membrane.

        Parameters
        ----------
        indenter
            A shape, such as Sphere.
        depth
            From the flat membrane to the highest point of the indenter, m.
        at, tilt
            Where the indenter's axis is, (x, y), m, from the middle, and its turns about x and then y, rad.
        settings
            How finely and how exactly to solve.
        start
            An earlier press of the same membrane to start from; it stays as it is.

        Raises
        ------
        NoEquilibrium
            There is no equilibrium, or none was found within the budget; `.reason` says which.
        """
        from stretch_bt.simulation.membrane.sheet.result import Load
        from stretch_bt.simulation.membrane.sheet.solver import solve

        if not (math.isfinite(depth) and depth > 0):
            raise InvalidInput(f"the depth must be a finite length above 0 m, not {depth!r}")
        if not isinstance(indenter, Indenter | Several):
            raise InvalidInput(f"an indenter is a shape such as Sphere(0.02), not {indenter!r}")
        return solve(self.sheet, Load(indenter, 0.0, depth, at, tilt), settings or Settings(), start)
