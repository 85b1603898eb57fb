"""Physical quantities: their dimensions, the units people write, and values with a standard deviation.

Inside the package every number is SI (m, kg, s, N, Pa, rad). Text from files and the command line carries its unit
(`10 mm`, `1.5 N/mm`); this module is the only place that reads it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number, plain_number
from stretch_bt.unit_words import units_like

__all__ = [
    "DIMENSIONLESS",
    "KINDS",
    "Angle",
    "AngularSpeed",
    "Area",
    "Curvature",
    "Dimension",
    "Estimate",
    "Force",
    "Frequency",
    "Kind",
    "Length",
    "Mass",
    "Pressure",
    "Speed",
    "Stiffness",
    "Time",
    "Torque",
    "Volume",
    "kind_of",
    "misspelt_quantity",
    "parse_quantity",
    "parse_unit",
    "suggest_quantity",
    "unit_names",
    "without_unit",
]


NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
PERCENTAGE_PATTERN = rf"^\s*{NUMBER}\s*%\s*$"
QUANTITY_PATTERN = rf"^\s*{NUMBER}\s*[A-Za-z%µ1].*$"


class Dimension(NamedTuple):
    """Exponents of metre, kilogram, second and radian."""

    length: int = 0
    mass: int = 0
    time: int = 0
    angle: int = 0

    def times(self, other: Dimension, power: int = 1) -> Dimension:
        """Return the dimension of self * other**power."""
        return Dimension(*(a + power * b for a, b in zip(self, other, strict=True)))

    def __str__(self) -> str:
        kind = kind_of(self)
        if kind is not None:
            return kind.name
        names = ("m", "kg", "s", "rad")
        parts = [n if e == 1 else f"{n}^{e}" for n, e in zip(names, self, strict=True) if e]
        return " ".join(parts) or "a plain number"


DIMENSIONLESS = Dimension()


@dataclass(frozen=True, slots=True)
class Kind:
    """A named kind of quantity: its dimension, its SI unit and the unit it is shown in."""

    name: str
    dimension: Dimension
    si_unit: str
    unit: str

    @property
    def scale(self) -> float:
        """SI value of one `unit`."""
        return parse_unit(self.unit)[0]

    def parse(self, text: object) -> float:
        """Return the SI value of text of this kind.

        Raises
        ------
        InvalidInput
            There is no unit, or one of another dimension; the text after the semicolon says what to write.
        """
        text = plain_number(text)
        if isinstance(text, bool) or not isinstance(text, int | float | str):
            raise InvalidInput(f"{text!r} is not a {self.name}; write a number and a unit, such as '10 {self.unit}'")
        try:
            value, dimension = parse_quantity(str(text))
        except InvalidInput as error:
            hint = suggest_quantity(str(text), self.dimension)
            raise InvalidInput(f"{error}; {hint}" if hint else str(error)) from None
        if dimension == DIMENSIONLESS and self.dimension != DIMENSIONLESS:
            raise InvalidInput("; ".join(without_unit(str(text), self.name, self.unit)))
        if dimension != self.dimension:
            raise InvalidInput(
                f"{text} is {dimension}, not {self.name}; use one of {', '.join(unit_names(self.dimension))}"
            )
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Let pydantic read fields of this kind from text with a unit."""
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(self.parse, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Describe the field as text with a unit."""
        return {"type": "string", "pattern": QUANTITY_PATTERN, "examples": [f"1 {self.unit}"]}


KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        Kind("Length", Dimension(1), "m", "mm"),
        Kind("Area", Dimension(2), "m^2", "mm^2"),
        Kind("Volume", Dimension(3), "m^3", "mm^3"),
        Kind("Curvature", Dimension(-1), "1/m", "1/mm"),
        Kind("Mass", Dimension(0, 1), "kg", "g"),
        Kind("Time", Dimension(0, 0, 1), "s", "s"),
        Kind("Frequency", Dimension(0, 0, -1), "Hz", "Hz"),
        Kind("Angle", Dimension(0, 0, 0, 1), "rad", "deg"),
        Kind("AngularSpeed", Dimension(0, 0, -1, 1), "rad/s", "deg/s"),
        Kind("Speed", Dimension(1, 0, -1), "m/s", "mm/s"),
        Kind("Acceleration", Dimension(1, 0, -2), "m/s^2", "mm/s^2"),
        Kind("Force", Dimension(1, 1, -2), "N", "N"),
        Kind("Torque", Dimension(2, 1, -2), "Nm", "Nmm"),
        Kind("Stiffness", Dimension(0, 1, -2), "N/m", "N/mm"),
        Kind("Pressure", Dimension(-1, 1, -2), "Pa", "kPa"),
    )
}

Length = Annotated[float, KINDS["Length"]]
Area = Annotated[float, KINDS["Area"]]
Volume = Annotated[float, KINDS["Volume"]]
Curvature = Annotated[float, KINDS["Curvature"]]
Mass = Annotated[float, KINDS["Mass"]]
Time = Annotated[float, KINDS["Time"]]
Frequency = Annotated[float, KINDS["Frequency"]]
Angle = Annotated[float, KINDS["Angle"]]
AngularSpeed = Annotated[float, KINDS["AngularSpeed"]]
Speed = Annotated[float, KINDS["Speed"]]
Force = Annotated[float, KINDS["Force"]]
Torque = Annotated[float, KINDS["Torque"]]
Stiffness = Annotated[float, KINDS["Stiffness"]]
Pressure = Annotated[float, KINDS["Pressure"]]

_BY_DIMENSION = {kind.dimension: kind for kind in reversed(KINDS.values())}

_UNITS: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, Dimension(1)),
    "dm": (1e-1, Dimension(1)),
    "cm": (1e-2, Dimension(1)),
    "mm": (1e-3, Dimension(1)),
    "um": (1e-6, Dimension(1)),
    "µm": (1e-6, Dimension(1)),
    "kg": (1.0, Dimension(0, 1)),
    "g": (1e-3, Dimension(0, 1)),
    "mg": (1e-6, Dimension(0, 1)),
    "s": (1.0, Dimension(0, 0, 1)),
    "ms": (1e-3, Dimension(0, 0, 1)),
    "us": (1e-6, Dimension(0, 0, 1)),
    "min": (60.0, Dimension(0, 0, 1)),
    "h": (3600.0, Dimension(0, 0, 1)),
    "Hz": (1.0, Dimension(0, 0, -1)),
    "kHz": (1e3, Dimension(0, 0, -1)),
    "rad": (1.0, Dimension(0, 0, 0, 1)),
    "mrad": (1e-3, Dimension(0, 0, 0, 1)),
    "deg": (math.pi / 180, Dimension(0, 0, 0, 1)),
    "N": (1.0, Dimension(1, 1, -2)),
    "mN": (1e-3, Dimension(1, 1, -2)),
    "kN": (1e3, Dimension(1, 1, -2)),
    "Nm": (1.0, Dimension(2, 1, -2)),
    "Nmm": (1e-3, Dimension(2, 1, -2)),
    "J": (1.0, Dimension(2, 1, -2)),
    "Pa": (1.0, Dimension(-1, 1, -2)),
    "kPa": (1e3, Dimension(-1, 1, -2)),
    "MPa": (1e6, Dimension(-1, 1, -2)),
    "GPa": (1e9, Dimension(-1, 1, -2)),
    "%": (1e-2, DIMENSIONLESS),
}

_LIKE_A_QUANTITY = re.compile(r"\s*([-+]?[0-9]+(?:[.,][0-9]+)?(?:[eE][-+]?[0-9]+)?)\s*([^\W\d_]\S*|°|)\s*")
_QUANTITY = re.compile(rf"\s*({NUMBER})\s*(.*?)\s*")
_FACTOR = re.compile(r"(1|%|[^\W\d_²³]+)(?:\^(-?[0-9]{1,2})|([²³]))?")


class Estimate(float):
    """A measured or computed value with its standard deviation `sd`, both SI; counts as its value in arithmetic."""

    __slots__ = ("sd",)
    sd: float

    def __new__(cls, value: float, sd: float) -> Estimate:
        """Make one; `sd` is not checked, so that a test of numbers can be."""
        made = super().__new__(cls, value)
        made.sd = float(sd)
        return made

    @property
    def value(self) -> float:
        """The value alone."""
        return float(self)

    def __eq__(self, other: object) -> bool:
        same = float(self) == other
        return same and self.sd == other.sd if isinstance(other, Estimate) else same

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return float.__hash__(self)

    def __repr__(self) -> str:
        return f"Estimate({float(self)!r}, {self.sd!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Estimate, (float(self), self.sd)


def kind_of(dimension: Dimension) -> Kind | None:
    """Return the named kind with this dimension, or None."""
    return _BY_DIMENSION.get(dimension)


def unit_names(dimension: Dimension) -> list[str]:
    """Return the simple units of a dimension, or its display unit where only compounds exist."""
    simple = [name for name, (_, d) in _UNITS.items() if d == dimension and name != "µm"]
    kind = kind_of(dimension)
    return simple or ([kind.unit] if kind else [])


@lru_cache(maxsize=256)  # a file has few units, each in many places
def parse_unit(text: str) -> tuple[float, Dimension]:
    """Return the SI scale and dimension of a unit such as `mm`, `N/mm`, `mm/s^2` or `1/mm`.

    Raises
    ------
    InvalidInput
        The text is not a unit.
    """
    scale, dimension = 1.0, DIMENSIONLESS
    if "%" in text and text.strip() != "%":
        raise InvalidInput(f"{text!r} is not a unit")  # a share of what would be multiplied in silence
    numerator, *denominators = text.split("/")
    for part, sign in ((numerator, 1), *((d, -1) for d in denominators)):
        factors = part.replace("*", " ").replace("·", " ").split()
        if not factors:
            raise InvalidInput(f"{text!r} is not a unit")
        for factor in factors:
            try:
                factor_scale, factor_dimension = _parse_factor(factor, text)
                scale *= factor_scale**sign
            except ArithmeticError:
                scale = math.inf
            if not 0.0 < scale < math.inf:
                raise InvalidInput(f"{text!r} is larger or smaller than any number")
            dimension = dimension.times(factor_dimension, sign)
    return scale, dimension


def _parse_factor(factor: str, text: str) -> tuple[float, Dimension]:
    match = _FACTOR.fullmatch(factor)
    if match is None or (match[1] != "1" and match[1] not in _UNITS):
        raise InvalidInput(f"{text!r} is not a unit")
    power = int(match[2] or {"²": 2, "³": 3}.get(match[3], 1))
    scale, dimension = _UNITS.get(match[1], (1.0, DIMENSIONLESS))
    return scale**power, DIMENSIONLESS.times(dimension, power)


def parse_quantity(text: str) -> tuple[float, Dimension]:
    """Return the SI value and dimension of text such as `10 mm`, `10mm` or `1.5 N/mm`; a bare number has none.

    Raises
    ------
    InvalidInput
        The text is not a number with a unit, or the value is not finite.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise InvalidInput(f"{text!r} is not a number with a unit")
    scale, dimension = parse_unit(match[2]) if match[2] else (1.0, DIMENSIONLESS)
    value = float(match[1]) * scale
    if not math.isfinite(value):
        raise InvalidInput(f"{text!r} is not a finite number")
    return value, dimension


def without_unit(text: str, name: str, unit: str) -> tuple[str, str]:
    """Return the complaint about a number where a quantity of a name and a usual unit is wanted, and what to write."""
    if "%" in text:
        return f"{text.strip()} is a part of something, not a {name}", f"write a number and a unit, as in '10 {unit}'"
    return f"{text.strip()} has no unit", f"write '{text.strip()} {unit}'"


def parse_time(what: str, given: str | float) -> float:
    """Return a time above 0 in s, from SI or text with a unit; `what` names it in the message of InvalidInput."""
    try:
        value, dimension = (given, KINDS["Time"].dimension) if is_number(given) else parse_quantity(str(given))
    except InvalidInput:
        value, dimension = 0.0, DIMENSIONLESS
    if dimension != KINDS["Time"].dimension or not value > 0:
        raise InvalidInput(f"{what} takes a time above 0, as in '10 s', not {shown(given)[:80]}")
    return float(value)


def suggest_quantity(text: str, dimension: Dimension) -> str:
    """Return advice for text that is no quantity: `write '10 mm'` for `10 milimeter`, `10 MM` or `10,0 mm`."""
    kind = kind_of(dimension)
    unit = kind.unit if kind else next(iter(unit_names(dimension)), "")
    match = _LIKE_A_QUANTITY.fullmatch(text)
    if match is None or not math.isfinite(float(match[1].replace(",", "."))):
        return f"write a number and a unit, as in '10 {unit}'"
    number, word = match[1].replace(",", "."), match[2]
    known = _known_units()
    fitting = [name for name in (word, *units_like(word, _known_units())) if known.get(name) == dimension]
    return f"write '{number} {fitting[0]}'" if fitting else f"use one of {', '.join(unit_names(dimension))}"


def misspelt_quantity(text: str) -> str | None:
    """Return advice for text that reads as a quantity of whatever kind, as `2 sec` does, and is none; None for any other text.

    A word that is written to the number without a space is taken for a unit only where it spells one out, or is one of two letters
    and more in another case: `2nd` and `6S` are text.
    """
    match = _LIKE_A_QUANTITY.fullmatch(text)
    if match is None or not match[2]:
        return None
    number, word = match[1].replace(",", "."), match[2]
    try:
        parse_unit(word)
        return f"write '{number} {word}'" if "," in match[1] else None
    except InvalidInput:
        like, apart = units_like(word, _known_units()), text.strip().count(" ") == 1
    if like and (apart or len(word) > 1):
        return f"write '{number} {like[0]}'"
    return "write a number and a unit, as in '10 mm'" if apart else None


def _known_units() -> dict[str, Dimension]:
    return {name: d for name, (_, d) in _UNITS.items()} | {k.unit: k.dimension for k in KINDS.values()}
