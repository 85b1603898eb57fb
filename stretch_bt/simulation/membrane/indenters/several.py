"""Several bodies that move as one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Indenter

__all__ = ["Part", "Several"]


class Part(NamedTuple):
    """An indenter at (x, y), m, whose highest point lies `below` the highest of all parts, m."""

    indenter: Indenter
    at: tuple[float, float]
    below: float = 0.0


@dataclass(frozen=True, slots=True)
class Several:
    """Bodies side by side; each presses on the sheet by itself."""

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        if not self.parts or min(p.below for p in self.parts) != 0:
            raise InvalidInput("several indenters need at least one part, and one whose top is the highest (below = 0)")
