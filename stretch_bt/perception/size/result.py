"""What a measurement of a contact hands on."""

from __future__ import annotations

from dataclasses import dataclass

from stretch_bt.units import Angle, Length

__all__ = ["ContactSize", "Diameters"]


@dataclass(frozen=True, slots=True)
class Diameters:
    """Widths of an object along i and j, m, with their standard deviations."""

    i: Length
    i_sd: Length
    j: Length
    j_sd: Length


@dataclass(frozen=True, slots=True)
class ContactSize:
    """Size of the object that a contact shows, SI, each number with its standard deviation.

    `shape` is the hypothesis that was chosen, `evidence` the natural logarithm of each one's evidence over the best
    one's. `center` (x, y) is in the frame of the points. The diameters are the widths along i and j through the centre, to
    the ends of the edge fillet. `sides` (short, long) and the `rotation` of the first from i are None for round shapes.
    `depth` is the height of the face over the undeformed membrane; `noise` is the standard deviation of one cell of 3 x 3 pixels.
    """

    shape: str
    evidence: dict[str, float]
    center: tuple[Length, Length]
    center_sd: tuple[Length, Length]
    diameter_i: Length
    diameter_i_sd: Length
    diameter_j: Length
    diameter_j_sd: Length
    depth: Length
    depth_sd: Length
    noise: Length
    sides: tuple[Length, Length] | None = None
    sides_sd: tuple[Length, Length] | None = None
    rotation: Angle | None = None
    rotation_sd: Angle | None = None
