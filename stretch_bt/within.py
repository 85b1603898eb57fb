"""Bounds of a quantity in a file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.quantity_text import digits_apart, format_quantity
from stretch_bt.units import KINDS, PERCENTAGE_PATTERN, parse_quantity

__all__ = ["Within"]


@dataclass(frozen=True, slots=True)
class Within:
    """Bounds of a field of a file, SI, both ends allowed: `Annotated[Length, Within(0.005, 0.080, "Length")]`."""

    min: float = -math.inf
    max: float = math.inf
    kind: str | None = None
    percent: bool = False  # of a number that is written so

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Refuse values outside the bounds, in the unit that the field is shown in; a plain number may be a percentage."""
        from pydantic_core import core_schema

        inner = handler(source)
        if source is float and self.kind is None:
            inner = core_schema.no_info_before_validator_function(_of_percentage, inner)
        return core_schema.no_info_after_validator_function(self.check, inner)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        """Describe a plain number as one that may be a percentage."""
        made = handler(schema)
        if made.get("type") == "number" and self.kind is None:
            return {**made, "type": ["number", "string"], "pattern": PERCENTAGE_PATTERN}
        return made

    def check(self, value: float) -> float:
        """Return the value; raises InvalidInput when it is out of bounds."""
        if self.min <= value <= self.max:
            return value
        digits = digits_apart(self._shown, value, self.min, self.max)
        given, least, most = (self._shown(v, digits) for v in (value, self.min, self.max))
        bounds = ((self.min, f"at least {least}"), (self.max, f"at most {most}"))
        allowed = " and ".join(text for bound, text in bounds if math.isfinite(bound))
        raise InvalidInput(f"{given} is out of bounds; write {allowed}")

    def _shown(self, value: float, digits: int) -> str:
        if self.percent:
            return f"{100 * value:.{max(digits, 6)}g} %"
        return format_quantity(value, KINDS[self.kind] if self.kind else None, digits)


def _of_percentage(given: Any) -> Any:
    """Return the number of a percentage, and anything else as it is."""
    if not isinstance(given, str) or "%" not in given:
        return given
    try:
        return parse_quantity(given)[0]
    except InvalidInput:
        return given
