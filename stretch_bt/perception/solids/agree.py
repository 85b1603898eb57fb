"""Whether a shape agrees with all that the presses over an object showed, beside the points that it was fitted to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.solids.domes import Dome
from stretch_bt.perception.solids.result import Dimension, Kind, Solid

__all__ = ["SURFACES", "contradiction", "outside", "surface_of_domes", "surface_of_points"]

Array = npt.NDArray[np.float64]
#: how far places lie outside the outline of a shape, m, less than 0 inside, and the height of its surface, m, by their places along
#: its length and across it, (n,), m, from its middle
Surface = Callable[[Mapping[str, Dimension], Array, Array], tuple[Array, Array]]

#: m outside an outline beyond which nothing of the shape is felt, and inside it beyond which it shows as it is
EDGE = 4e-3
OFF = 1.5e-3  # m, difference from which a surface is surely another
LIFTED = 0.1e-3  # m above a flat top that its edges hold a membrane which resists bending: it then hangs over a face as over a hole
AREA, SHARE = 40, 0.05  # cells that disagree, and their share of those felt, from which the shape is another
WIRE = 0.5e-3  # m added to the distance from a wire: the part of it that is felt is narrower
CAP = 0.7  # of a dome's radius, within which its surface is judged: farther out it is steeper than is felt
FALL = 0.2  # of the flanks of a point, at least
#: cells, and the share of those well inside an outline, from which they show another surface, or none: of paper that bears little
#: a part is not felt
FEW, PART = 20, 0.25


def _block(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    sides = size["length"].value, size["width"].value
    outside = np.maximum(np.abs(along) - sides[0] / 2, np.abs(across) - sides[1] / 2)
    return outside, np.full(len(along), size["height"].value)


def _disc(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    return np.hypot(along, across) - size["radius"].value, np.full(len(along), size["height"].value)


def _half_cylinder(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    radius = size["radius"].value
    outside = np.maximum(np.abs(along) - size["length"].value / 2, np.abs(across) - radius)
    return outside, size["height"].value - radius + np.sqrt(np.maximum(radius**2 - across**2, 0.0))


def _ridge(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    return np.abs(along) - size["length"].value / 2, np.full(len(along), np.nan)  # its flanks are as steep as they are


def _wire_circle(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    return np.abs(np.hypot(along, across) - size["radius"].value) + WIRE, np.full(len(along), np.nan)


def _wire_triangle(size: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
    normals = np.arange(3) * 2 * np.pi / 3
    out = (np.stack([along, across], axis=1) @ np.stack([np.cos(normals), np.sin(normals)])).max(axis=1)
    return np.maximum(out - size["side"].value / (2 * np.sqrt(3)), -EDGE), np.full(len(along), np.nan)


def surface_of_domes(found: Sequence[Dome], radii: Sequence[Dimension], middle: Array, heading: float) -> Surface:
    """Return the surface of domes, spheres of their radii below their tops, from a middle (2,), m, world, and a heading, rad."""
    places = [_from(dome.middle, middle, heading) for dome in found]

    def surface(_: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
        outside, height = np.full(len(along), np.inf), np.zeros(len(along))
        for dome, known, (x, y) in zip(found, radii, places, strict=True):
            radius, away = known.value, np.hypot(along - x, across - y)
            near = np.where(away < CAP * radius, -radius, np.maximum(away - radius, -EDGE))
            outside = np.minimum(outside, near)
            cap = dome.height.value - radius + np.sqrt(np.maximum(radius**2 - away**2, 0.0))
            height = np.maximum(height, np.where(away < radius, cap, 0.0))
        return outside, height

    return surface


def surface_of_points(found: Sequence[Dome], middle: Array, heading: float) -> Surface:
    """Return the surface below which points lie, whose flanks are flat nowhere, from a middle (2,), m, world, and a heading, rad."""
    places = [_from(dome.middle, middle, heading) for dome in found]

    def surface(_: Mapping[str, Dimension], along: Array, across: Array) -> tuple[Array, Array]:
        away = [np.hypot(along - x, across - y) for x, y in places]
        height = [d.height.value - FALL * np.maximum(a - EDGE, 0.0) for d, a in zip(found, away, strict=True)]
        return -np.minimum.reduce(away), np.maximum.reduce(height)

    return surface


def _from(place: Array, middle: Array, heading: float) -> tuple[float, float]:
    (x, y), c, s = place - middle, np.cos(heading), np.sin(heading)
    return float(x * c + y * s), float(y * c - x * s)


SURFACES: Mapping[Kind, Surface] = {
    "block": _block,
    "disc": _disc,
    "half_cylinder": _half_cylinder,
    "ridge": _ridge,
    "wire_circle": _wire_circle,
    "wire_triangle": _wire_triangle,
}
FLAT: frozenset[Kind] = frozenset({"block", "disc"})
BELOW: frozenset[Kind] = frozenset({"point"})  # that may lie anywhere below their surface


def outside(solid: Solid, places: Array) -> Array:
    """Return how far world places (n, 2), m, lie outside a block or a disc, m, less than 0 inside; of other shapes 0."""
    if solid.kind not in FLAT:
        return np.zeros(len(places))
    away, c, s = places - solid.middle[:2], np.cos(solid.heading), np.sin(solid.heading)
    return SURFACES[solid.kind](solid.dimensions, away @ [c, s], away @ [-s, c])[0]


def contradiction(
    kind: Kind, surface: Surface, dimensions: Mapping[str, Dimension], relief: Relief, middle: Array, heading: float
) -> str:
    """Return why the presses contradict a shape with `middle` (2,), m, world, and `heading`, rad; nothing where they do not.

    Surface that was felt outside its outline or above it is of something else, and so is a shape below whose surface a membrane
    hung, and a flat face over which one hung freely that the edges do not lift off it.
    """
    seen = np.isfinite(relief.ceiling)
    away = relief.place(np.argwhere(seen)) - middle
    along, across = away @ [np.cos(heading), np.sin(heading)], away @ [-np.sin(heading), np.cos(heading)]
    outside, height = surface(dimensions, along, across)
    felt, inside = relief.felt[seen], outside < -EDGE
    above = felt & inside & (relief.height[seen] - height > OFF)
    below = inside & (height - relief.ceiling[seen] > OFF) & (kind not in BELOW)
    lifted = -dimensions["height"].steps.get("membrane", 0.0) > LIFTED
    free = inside & (relief.hung > relief.weight)[seen] & (kind in FLAT and not lifted)
    most, part = max(AREA, SHARE * felt.sum()), max(FEW, PART * inside.sum())
    for cells, limit, why in (
        (felt & (outside > EDGE), most, "of surface was felt outside it"),
        (above, min(most, part), "of surface was felt above it"),
        (below, min(most, part), "of it lie above where the membrane hung"),
        (free, part, "of it is no face: the membrane hung freely there"),
    ):
        if cells.sum() > limit:
            return f"{1e6 * cells.sum() * relief.cell**2:.0f} mm^2 {why}"
    return ""
