"""A lump of dough, cut as a cube, that the hand rolls and presses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.effects.active import Active
from stretch_bt.simulation.objects.base import HertzForm, ObjectSpec, Rough
from stretch_bt.units import Length, Mass, Pressure, Stiffness
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.dough.specimen import DoughSpecimen
    from stretch_bt.simulation.membrane.indenters.base import Indenter

__all__ = ["DoughObject"]

GRAVITY = 9.81
_DENSITY = 1250.0  # kg/m^3, of a paste of flour, salt and water
_FILLET = 1e-3


class DoughObject(ObjectSpec):
    """A lump of dough, cut as a cube, that lies on a face and rolls under the hand."""

    effects: ClassVar[tuple[str, ...]] = (
        "plasticity",
        "springback",
        "dough_viscosity",
        "tack",
        "edge_cracks",
        "spin_noise",
    )

    type: Literal["dough"]
    edge: Annotated[Length, Within(0.005, 0.060, "Length")] = Field(default=0.025, description="edge of the cube")
    yield_stress: Annotated[Pressure, Within(1.0, 1e9, "Pressure")] = Field(
        default=5e3, description="yield stress in uniaxial compression"
    )
    modulus: Annotated[Pressure, Within(1e2, 1e12, "Pressure")] = Field(default=1e5, description="elastic modulus")
    mass: Annotated[Mass, Within(0.0, 1.0, "Mass")] | None = Field(
        default=None, description="mass; by default the density is 1.25 g/cm3"
    )
    smoothing: Annotated[Stiffness, Within(0.0, 1e3, "Stiffness")] = Field(
        default=20.0, description="tension of the membrane that smooths it where it is sharp"
    )
    directions: int = Field(default=500, ge=100, le=8000, description="directions in which its radius is known")

    @model_validator(mode="after")
    def _stands(self) -> DoughObject:
        pressure = self.weight / self.edge**2
        if pressure > self.yield_stress:
            raise InvalidInput(
                f"it would spread under its own weight, which is {pressure:.3g} Pa on its foot; write a larger yield_stress"
            )
        return self

    @property
    def top(self) -> float:
        """World height of its top, m."""
        return self.base + self.edge

    @property
    def reach(self) -> float:
        """Distance from its middle to a corner, m, and a little more for a shape that it may get."""
        return 0.95 * self.edge

    @property
    def ball(self) -> float:
        """Radius of the ball of its volume, m."""
        return self.edge * math.cbrt(0.75 / math.pi)

    @property
    def weight(self) -> float:
        """Its weight, N."""
        return GRAVITY * (_DENSITY * self.edge**3 if self.mass is None else self.mass)

    @property
    def hertz(self) -> HertzForm:
        """The ball of its volume, however round it is by now."""
        return HertzForm("sphere", self.ball)

    def body(self) -> Indenter:
        """Return the cube as it was cut."""
        from stretch_bt.simulation.membrane.indenters.cube import Cube

        return Cube(self.edge, _FILLET)

    def rough(self) -> Rough:
        """Return the radius of its ball, its weight, and its stiffness where it begins to flow."""
        elastic, flowing = 4 / 3 * self.modulus * self.ball, 4 * math.pi * self.ball * self.yield_stress
        return Rough(self.ball, 1 / (1 / elastic + 1 / flowing), self.weight, _FILLET, flattens=True)

    def known(self) -> dict[str, float]:
        """Return the radius, m, of the ball of its volume, and its yield stress, Pa."""
        return {"radius": self.ball, "yield_stress": self.yield_stress}

    def specimen(self, effects: Active) -> DoughSpecimen:
        """Return the dough as it is at the begin of a run."""
        from stretch_bt.simulation.dough.specimen import DoughSpecimen

        return DoughSpecimen(self, effects)
