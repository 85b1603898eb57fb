"""What was read of an object's top since it was approached."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.tree.context import Context
from stretch_bt.units import Length

__all__ = ["Reading", "readings_of"]


@dataclass(frozen=True, slots=True)
class Reading:
    """The height of the top, m, world, with its standard deviation, at a stretch and a depth of the membrane, m."""

    stretch: Length
    depth: Length
    height: Length
    sd: Length


def readings_of(context: Context) -> list[Reading]:
    """Return the readings of the run so far; `approach` empties the list."""
    found: list[Reading] = context.memory.setdefault(Reading, [])
    return found
