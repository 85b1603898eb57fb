"""The parts of a scene file that do not depend on the objects and effects there are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.units import Angle, Length, Pressure, Speed, Time
from stretch_bt.within import Within

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.materials import Material

__all__ = ["CameraPose", "Conditioned", "Conditions", "Cup", "Dimension", "Hand", "Table", "Tolerance"]

#: the values for which E* of a 20 mm hemisphere, fitted over depths of 1 to 15 mm in steps of 1 mm, is 4 kPa at stretch 0 and 9 kPa at
#: 60 mm, with the weight and the bending of the membrane: a fit to two figures of the paper (arXiv 2105.08154), not a measurement
SHEAR_MODULUS, MOUNT_PRESTRETCH = 68.4e3, 11.9e-3

#: a graded dimension of the object
Dimension = Annotated[Length, Within(1e-5, 1.0, "Length")]

_Offset = Annotated[Length, Within(-0.05, 0.05, "Length")]
_Tilt = Annotated[Angle, Within(-0.35, 0.35, "Angle")]
_Millimetres = Annotated[Length, Within(1e-6, 0.1, "Length")]


class Fraction:
    """Marks a number that may be written as a percentage."""

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> object:
        """Read `5 %` or `0.05`."""
        from pydantic_core import core_schema

        from stretch_bt.plain_numbers import plain_number
        from stretch_bt.units import DIMENSIONLESS, parse_quantity

        def read(given: object) -> float:
            given = plain_number(given)
            if isinstance(given, bool) or not isinstance(given, int | float | str):
                raise InvalidInput(f"takes a percentage, not {shown(given)[:80]}; write '5 %'")
            value, dimension = parse_quantity(str(given))
            if dimension != DIMENSIONLESS:
                raise InvalidInput(f"takes a percentage, not {shown(given)[:80]}; write '5 %'")
            return value

        return core_schema.no_info_before_validator_function(read, handler(source))  # type: ignore[operator]

    def __get_pydantic_json_schema__(self, schema: object, handler: object) -> dict[str, object]:
        """Describe it as text or a number."""
        return {"type": ["string", "number"], "examples": ["5 %"]}


_Part = Annotated[float, Fraction(), Within(1e-6, 10.0, percent=True)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class CameraPose(_Model):
    """How the camera really stands, against where the cell file has it: over the membrane's centre, looking straight down."""

    x: _Offset = 0.0
    y: _Offset = 0.0
    z: _Offset = Field(default=0.0, description="offset away from the membrane")
    tilt_x: _Tilt = Field(default=0.0, description="tilt about the membrane's x axis")
    tilt_y: _Tilt = Field(default=0.0, description="tilt about its y axis")


class Conditioned(_Model):
    """A press of a ball in the middle of the membrane, deep enough that the membrane is at its softest afterwards."""

    diameter: Annotated[Length, Within(0.002, 0.2, "Length")] = Field(
        default=0.060, description="diameter of the ball that pressed the membrane; without `conditioned` it is fresh"
    )
    stretch: Annotated[Length, Within(0.0, 0.2, "Length")] = Field(default=0.080, description="stretch of the membrane")
    depth: Annotated[Length, Within(0.0005, 0.05, "Length")] = Field(
        default=0.015, description="depth past first contact"
    )


class Hand(_Model):
    """The hand as it really is; its size comes from the cell file."""

    shear_modulus: Annotated[Pressure, Within(1e3, 1e7, "Pressure")] = Field(
        default=SHEAR_MODULUS, description="shear modulus of the membrane"
    )
    second_invariant: Annotated[float, Within(0.0, 1.0)] = Field(
        default=0.0, description="share of the second invariant in Mooney and Rivlin's energy; neo-Hookean without"
    )
    mount_prestretch: Annotated[Length, Within(0.0, 0.2, "Length")] = Field(
        default=MOUNT_PRESTRETCH, description="prestretch of the membrane by its mounts, at stretch 0"
    )
    conditioned: Conditioned | None = Field(
        default=None,
        description="press before the task, which a membrane with `mullins` remembers; without it the membrane is fresh",
    )
    frame: Annotated[Length, Within(0.001, 0.1, "Length")] | None = Field(
        default=None,
        description="distance behind the flat membrane at which the hand's rigid frame stops an object; without it nothing does",
    )
    camera: CameraPose = CameraPose()

    def material(self) -> Material:
        """Return the material of the membrane."""
        from stretch_bt.simulation.membrane.materials import rubber

        return rubber(self.shear_modulus, self.second_invariant)


class Table(_Model):
    """A flat table at height 0."""

    type: Literal["table"] = "table"


class Cup(_Model):
    """A cup on the table that holds a soft object; its rim is where the exposed part begins."""

    type: Literal["cup"]
    diameter: Annotated[Length, Within(0.005, 0.3, "Length")] = Field(description="inner diameter at the rim")
    rim: Annotated[Length, Within(0.001, 0.5, "Length")] = Field(description="height of the rim above the table")


class Tolerance(_Model):
    """Largest errors of results with which the scene still serves; a result that is not named does not matter."""

    height: _Millimetres | None = Field(default=None, description="height error of the top, and of surface points")
    size: _Millimetres | None = Field(default=None, description="error of widths, diameters and radii")
    force: _Part | None = Field(default=None, description="error over the force")
    stiffness: _Part | None = Field(default=None, description="error over the stiffness")
    roundness: _Part | None = Field(default=None, description="standard deviation of the radius over its mean")

    @model_validator(mode="after")
    def _something(self) -> Tolerance:
        if not self.named():
            raise InvalidInput("a tolerance names at least one result; write 'height: 0.3 mm'")
        return self

    def named(self) -> dict[str, float]:
        """Return the tolerances that are named, SI."""
        return {name: value for name, value in self.model_dump().items() if value is not None}


_Frequent = Annotated[int, Field(ge=1, le=1000)]


class Conditions(_Model):
    """The use of the hand in the scene, as far as the advisor needs to know it."""

    stretch: Annotated[Length, Within(0.0, 0.2, "Length")] = Field(default=0.0, description="lowest stretch in use")
    depth: Annotated[Length, Within(0.0001, 0.1, "Length")] = Field(default=0.010, description="deepest press")
    hold: Annotated[Time, Within(0.0, 1e5, "Time")] = Field(default=0.5, description="time that a press is held")
    speed: Annotated[Speed, Within(0.0, 1.0, "Speed")] = Field(default=0.005, description="speed of the hand when read")
    frames: _Frequent = Field(default=8, description="frames averaged at each press")
    travel: Annotated[Length, Within(0.0, 100.0, "Length")] = Field(default=0.0, description="way across, in contact")
    presses: _Frequent = Field(default=1, description="presses at the same place, each deeper than the one before")


#: tolerance that decides `effects: auto` in a scene without one
USUAL = Tolerance.model_validate({"height": "0.3 mm", "force": "3 %"})
