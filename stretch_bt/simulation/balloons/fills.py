"""The fills of a balloon, as a scene names them. The numbers are assumptions: no source measures them."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from stretch_bt.simulation.balloons.filling import ATMOSPHERE, Gas
from stretch_bt.simulation.balloons.laws import hertz, no_force
from stretch_bt.simulation.objects.response import Law
from stretch_bt.units import Pressure, Time, Volume
from stretch_bt.within import Within

__all__ = ["Air", "AnyFill", "Fill", "Pudding", "Seeds", "Water", "cap_volume"]


def cap_volume(radius: float) -> float:
    """Return the volume of a hemisphere, m^3."""
    return 2 / 3 * math.pi * radius**3


class Fill(BaseModel):
    """The base of every fill; without more it is a liquid that nothing but the skin holds."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    #: object effects that a balloon with it can have
    effects: ClassVar[tuple[str, ...]] = ("compliance", "latex_softening", "flattening")
    #: whether the skin carries the push
    by_skin: ClassVar[bool] = True

    type: str

    def body(self, radius: float, pressure: float) -> Law:
        """Return the force of the fill itself, beside the force of the skin around it."""
        return no_force


class Air(Fill):
    """Air."""

    effects: ClassVar[tuple[str, ...]] = (*Fill.effects, "gas_compressibility")

    type: Literal["air"]
    below: Annotated[Volume, Within(0.0, 0.1, "Volume")] | None = Field(
        default=None, description="volume of air below the rim; as much as above it unless given"
    )
    exponent: Annotated[float, Within(1.0, 1.67)] = Field(
        default=1.0, description="exponent of its gas law: 1 for a press that lasts seconds, 1.4 for one below a second"
    )

    def gas(self, radius: float) -> Gas:
        """Return the air as the cap's solver takes it."""
        return Gas(cap_volume(radius) if self.below is None else self.below, self.exponent)

    def softness(self, radius: float, pressure: float) -> float:
        """Return beta = p (V + V_below) / (V gamma (p + p_air)): the squeeze of the gas by the pressure, over the cap's volume."""
        cap = cap_volume(radius)
        whole = 2 * cap if self.below is None else cap + self.below
        return pressure * whole / (cap * self.exponent * (ATMOSPHERE + pressure))


class Water(Fill):
    """Water, or any liquid: it keeps its volume."""

    type: Literal["water"]


class Pudding(Fill):
    """A gel of soaked seeds in its liquid: the skin holds both, and the gel carries a share of its own."""

    effects: ClassVar[tuple[str, ...]] = (*Fill.effects, "viscosity")

    type: Literal["pudding"]
    modulus: Annotated[Pressure, Within(1.0, 1e6, "Pressure")] = Field(
        default=20e3, description="effective modulus of the gel once it has relaxed"
    )
    sudden: Annotated[Pressure, Within(1.0, 1e6, "Pressure")] = Field(
        default=20e3, description="modulus that a sudden push meets beyond that"
    )
    time: Annotated[Time, Within(1e-3, 1e4, "Time")] = Field(default=2.0, description="time constant of its relaxation")

    def body(self, radius: float, pressure: float) -> Law:
        """Return the force of the relaxed gel: a slow hand meets no more, and earlier presses do not matter."""
        return hertz(self.modulus, radius)


class Seeds(Fill):
    """Dry grains that the skin presses together; they carry the push."""

    effects: ClassVar[tuple[str, ...]] = ("compliance", "granular_hysteresis", "flattening")
    by_skin: ClassVar[bool] = False

    type: Literal["seeds"]
    modulus: Annotated[Pressure, Within(1e3, 1e8, "Pressure")] = Field(
        default=0.6e6, description="effective modulus of the grains at 100 kPa; it goes as the root of the pressure"
    )
    unloading: Annotated[float, Field(gt=1.0, le=100.0), Within()] = Field(
        default=3.0, description="stiffness of the grains in unloading over their stiffness in loading"
    )

    def body(self, radius: float, pressure: float) -> Law:
        """Return the force of the grains, E sqrt(p / 100 kPa), as a ball."""
        return hertz(self.modulus * math.sqrt(pressure / 1e5), radius)


AnyFill = Annotated[Air | Water | Pudding | Seeds, Field(discriminator="type")]
