"""What an operator can mount: the geometries, what their sizes may be, and how a person calls them."""

from __future__ import annotations

import math

from stretch_bt.errors import InvalidInput
from stretch_bt.quantity_text import format_apart
from stretch_bt.units import KINDS

__all__ = ["GEOMETRIES", "check_indenter", "described"]

#: by name, the kind of its size and the bounds of that, SI
GEOMETRIES = {
    "sphere": ("Length", 0.005, 0.080),
    "cylinder": ("Length", 0.005, 0.080),
    "cone": ("Angle", 0.05, 1.5),
}


def check_indenter(geometry: str, size: float) -> None:
    """Raise InvalidInput unless the geometry is known and its size, m or rad, within bounds."""
    if geometry not in GEOMETRIES:
        raise InvalidInput(f"there is no indenter {geometry!r}; write one of {', '.join(GEOMETRIES)}")
    kind, low, high = GEOMETRIES[geometry]
    if not (math.isfinite(size) and low <= size <= high):
        asked, least, most = format_apart(KINDS[kind], size, low, high)
        raise InvalidInput(f"no {geometry} of {asked} can be mounted; use {least} to {most}")


def described(geometry: str, size: float) -> str:
    """Return an indenter as a person calls it, such as `a sphere of 20 mm`."""
    if geometry == "cone":
        return f"a cone of {math.degrees(size):.4g} degrees between its surface and the membrane"
    return f"a {geometry} of {size * 1e3:.4g} mm diameter"
