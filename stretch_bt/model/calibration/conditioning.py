"""The presses of a membrane before it was measured, on which its softening depends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeGuard

from stretch_bt.errors import InvalidInput
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS

__all__ = ["CONDITIONED", "Conditioning"]

#: in the provenance of a table
CONDITIONED = "conditioned"
_LENGTH = KINDS["Length"]
_DIGITS = 9


class Conditioning(NamedTuple):
    """The stretch and the depth, m, to which each indenter was pressed before it was measured; both are 0 when it was not."""

    stretch: float = 0.0
    depth: float = 0.0

    @property
    def softens(self) -> bool:
        """Whether the membrane was pressed at all."""
        return self.depth > 0

    def __str__(self) -> str:
        if not self.softens:
            return "not conditioned"
        stretch, depth = (format_quantity(v, _LENGTH) for v in self)
        return f"conditioned to a stretch of {stretch} and a depth of {depth}"

    def to_json(self) -> dict[str, float]:
        """Return the entry of a table's provenance, m."""
        return {name: round(value, _DIGITS) for name, value in self._asdict().items()}

    @classmethod
    def of(cls, provenance: Mapping[str, Any]) -> Conditioning | None:
        """Return the conditioning in the provenance of a table, None where it has none.

        Raises
        ------
        InvalidInput
            The entry is no stretch and depth.
        """
        given = provenance.get(CONDITIONED)
        if given is None:
            return None
        stretch, depth = (given.get(name) if isinstance(given, dict) else None for name in cls._fields)
        if not (_length(stretch) and _length(depth)):
            raise InvalidInput(
                f"{CONDITIONED}: a table says to which stretch and depth its membrane was conditioned, in m, "
                f'as {{"stretch": 0.08, "depth": 0.015}}, not {given!r}; restore its first line'
            )
        return cls(stretch, depth)


def _length(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < math.inf
