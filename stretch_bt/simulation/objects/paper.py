"""The common part of objects folded from paper: walls that buckle, a roof that sags, and next to no weight."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.objects.base import Rough
from stretch_bt.simulation.objects.buckling import BucklingResponse, plate_buckling_force
from stretch_bt.simulation.objects.loose import LooseSpec
from stretch_bt.simulation.objects.roof import RoofResponse
from stretch_bt.units import Length, Pressure
from stretch_bt.within import Within

__all__ = ["PaperSpec", "Walls"]

_POISSON = 0.3
_DENSITY, _GRAVITY = 800.0, 9.81
_USUAL_PRESS = 1.5  # N, about the force of a press of 10 mm at stretch 0 on a top of 40 mm


class Walls(NamedTuple):
    """Equal plates that carry the load: how many, the width b of one and its height along the load, m."""

    number: int
    width: float
    height: float


class PaperSpec(LooseSpec, ABC):
    """Options of an object folded from a sheet of paper, hollow and open below; its figures are assumptions."""

    effects: ClassVar[tuple[str, ...]] = ("compliance", "roof_sag", "rigid_shift")

    thickness: Annotated[Length, Within(2e-5, 1e-3, "Length")] = Field(default=1e-4, description="sheet's thickness")
    modulus: Annotated[Pressure, Within(1e7, 2e10, "Pressure")] = Field(
        default=3e9, description="Young's modulus of the sheet; 2 to 5 GPa along the fibres of copy paper"
    )
    bow: Annotated[Length, Within(0.0, 0.01, "Length")] = Field(
        default=0.001, description="distance that the middle of a wall stands out before any load"
    )
    edge: Annotated[Length, Within(0.0002, 0.005, "Length")] = Field(default=0.001, description="radius of its folds")

    @property
    @abstractmethod
    def walls(self) -> Walls:
        """The plates that carry the load."""

    @property
    @abstractmethod
    def face(self) -> float:
        """Radius of the disc that its flat top or its crest is as wide as, m; 0 for a point."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Area of the paper, m^2."""

    @property
    def bending_stiffness(self) -> float:
        """D of the sheet, N m."""
        return self.modulus * self.thickness**3 / (12 * (1 - _POISSON**2))

    @property
    def own_weight(self) -> float:
        """Its weight, N."""
        return _DENSITY * _GRAVITY * self.thickness * self.area

    def compliance(self) -> BucklingResponse:
        """Return its walls: plates pressed along their height that buckle.

        A flat plate is E t b / h stiff. One whose middle stands out by w0 shortens also as its bow grows to w0 / (1 - F / F_cr)
        (Timoshenko and Gere, section 1.12): a half wave w sin(pi x / h) sin(pi y / b) takes pi^2 w^2 / (8 h) off its height on
        the mean over its width, so at small loads the bow gives way by pi^2 w0^2 / (4 h F_cr) per force.
        """
        number, width, height = self.walls
        critical = plate_buckling_force(self.bending_stiffness, width, number)
        flat = height / (self.modulus * self.thickness * width * number)
        bowed = math.pi**2 * self.bow**2 / (4 * height) / critical
        return BucklingResponse(1 / (flat + bowed), critical)

    def roof(self, share: float) -> RoofResponse:
        """Return how its roof sags under a force of which it bears a share.

        Raises
        ------
        InvalidInput
            It has none.
        """
        raise InvalidInput(f"a {self.type} has no roof")

    def rough(self) -> Rough:
        """Return half its width, its stiffness under a usual press, and its weight."""
        stiffness = _USUAL_PRESS / self.compliance().given(_USUAL_PRESS)
        round_top = self.walls.width / 2 if self.face else self.edge
        return Rough(round_top, stiffness, weight=self.own_weight, edge=self.edge, loose=True, face=self.face)
