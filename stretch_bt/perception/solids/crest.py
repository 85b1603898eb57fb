"""A crest: the ridge of a prism, or the crest of a half-cylinder."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.solids.arc import Arc, fit_arc
from stretch_bt.perception.solids.bend import Bend, fit_bend, search_bend
from stretch_bt.perception.solids.conformity import beyond_end
from stretch_bt.perception.solids.profile import HeightProfile, profile_of
from stretch_bt.perception.solids.result import Dimension, pooled
from stretch_bt.perception.solids.top import Top
from stretch_bt.perception.solids.views import SolidView

__all__ = ["Crest", "crest_of", "evidence_of_crest", "half_cylinder", "ridge", "unlike_crest", "unlike_half_cylinder"]

Array = npt.NDArray[np.float64]

MIDDLE = 0.6  # share of a crest's half length over which its cross-section is taken
BAND = 1.5e-3  # m to either side of a crest along which its ends are sought
REACH = 14e-3  # m to either side of a crest
SHARED = 0.15e-3  # m, error that all heights, or all bends of an end, share
LAYER, LAYER_SD = (
    2.4e-3,
    0.2e-3,
)  # m: sqrt(bending stiffness / tension) of the hand's membrane near a ridge, over presses
ROUND_SD = 0.15  # of the logarithm of a radius by the arc
RADIUS_SD = 0.12  # of a radius by the arc, over presses
DIFFERENT = (
    0.36  # logarithm of a height over a radius, beyond which the shape does not stand on the table with its flat side
)
FLATTER = 2.0  # radius over height, from which an arc is surely not of a half-cylinder, however lightly it is touched
SURE = 2.0  # standard deviations of its logarithm
ONE_SIDED = 0.2  # of the change of slope at a crest, below which its gentler side is the face of a top that leans
PLAIN = 4.0  # nats that a radius costs that does not follow from the height


@dataclass(frozen=True, slots=True)
class Crest:
    """A crest with its cross-sections as bends and as arcs, one of a view each."""

    top: Top
    bends: list[Bend]
    arcs: list[Arc]
    radius: float
    layer: float


def crest_of(views: list[SolidView], top: Top) -> Crest:
    """Return the cross-section of a crest by the views that show it.

    Raises
    ------
    IllConditioned
        None does.
    """
    across = np.array([-top.along[1], top.along[0]])
    bends, arcs = [], []
    for view in views:
        profile = profile_of(view, top.middle, across, MIDDLE * top.half[0], -1.5 * REACH, 1.5 * REACH)
        try:
            bends.append(fit_bend(profile, 0.0, reach=REACH))
            arcs.append(_arc(profile, bends[-1].place))
        except IllConditioned:
            continue
    if not arcs:
        raise IllConditioned("no view shows the membrane on both sides of the crest; press nearer to it")
    return Crest(top, bends, arcs, _radius(arcs), float(np.median([b.length for b in bends])))


def _arc(profile: HeightProfile, bent: float) -> Arc:
    """Return the arc that fits a profile best, begun at the crest or, m, where it seems to bend: a wide one bends nowhere."""
    return min(
        (fit_arc(profile, start, reach=REACH, layer=(LAYER, LAYER_SD)) for start in (0.0, bent)), key=lambda a: a.rms
    )


def _radius(arcs: list[Arc]) -> float:
    """Return the mean radius of arcs, m, weighted by how surely each shows it: one touched along a line does not."""
    weights = [1 / ((arc.radius_sd / arc.radius) ** 2 + RADIUS_SD**2) for arc in arcs]
    return math.exp(float(np.average([math.log(arc.radius) for arc in arcs], weights=weights)))


def evidence_of_crest(crest: Crest) -> dict[str, float]:
    """Return the evidence, nats, for a ridge and for a half-cylinder.

    A ridge is rounded by the membrane's own stiffness alone. A half-cylinder on the table is as high as its radius, and the
    membrane that lies on it is no sharper; where it is rounder it touches along a line, and does not show its radius.
    """
    sharper = max(crest.layer - LAYER, 0.0) / LAYER_SD
    off = max(math.log(max(crest.top.height, 1e-4) / crest.radius), 0.0) / ROUND_SD
    return {"ridge": -0.5 * sharper**2, "half_cylinder": -0.5 * min(off**2, 2 * PLAIN)}


def unlike_crest(crest: Crest) -> str:
    """Return why a crest is of no ridge and no half-cylinder: the high edge of a top that leans falls on one side alone.

    A wide arc bends nowhere, so that its bend, which may lie anywhere on it, does not tell.
    """
    gentler = float(np.median([min(bend.near, -bend.far) / max(bend.change, 1e-6) for bend in crest.bends]))
    return (
        ""
        if gentler > ONE_SIDED or crest.layer > LAYER
        else "the crest falls on one side alone, as the high edge of a top that leans does"
    )


def unlike_half_cylinder(crest: Crest) -> str:
    """Return why a crest is of no half-cylinder on the table: it is no crest, or too flat for its height."""
    shown = sum((arc.radius / max(arc.radius_sd, 1e-9)) ** 2 for arc in crest.arcs)
    flatter = math.log(crest.radius / max(crest.top.height, 1e-4)) - SURE * math.hypot(shown**-0.5, ROUND_SD)
    if flatter > math.log(FLATTER):
        return (
            f"the top is too flat: an arc of {1e3 * crest.radius:.0f} mm at a height of {1e3 * crest.top.height:.0f} mm"
        )
    return unlike_crest(crest)


def ridge(views: list[SolidView], crest: Crest, floor: float, fillet: tuple[float, float]) -> dict[str, Dimension]:
    """Return the length and the height of a ridge."""
    return {"length": _length(views, crest, fillet, sharp=True), "height": _height(crest, floor)}


def half_cylinder(
    views: list[SolidView], crest: Crest, floor: float, fillet: tuple[float, float]
) -> dict[str, Dimension]:
    """Return length, radius and height of a half-cylinder that lies on its flat side.

    Its radius is the mean of its arc's radius and of its height, where these agree; else the arc's radius.
    """
    height = _height(crest, floor)
    seen = Dimension(crest.radius, RADIUS_SD * crest.radius, {})
    length = _length(views, crest, fillet, sharp=False)
    return {"length": length, "radius": _on_table(seen, height), "height": height}


def _on_table(seen: Dimension, height: Dimension) -> Dimension:
    """Return a radius from an arc's and from the height of a shape that stands on the table with its flat side."""
    if math.log(max(height.value, 1e-6) / seen.value) > DIFFERENT:
        return seen
    weights = seen.sd**-2, height.sd**-2
    value = (weights[0] * min(seen.value, 1.5 * height.value) + weights[1] * height.value) / sum(weights)
    return Dimension(value, max(sum(weights) ** -0.5, height.sd), {"table": value - seen.value})


def _height(crest: Crest, floor: float) -> Dimension:
    found = [Dimension(arc.height, arc.height_sd, {}) for arc in crest.arcs]
    return pooled(found, math.hypot(floor, SHARED))


def _length(views: list[SolidView], crest: Crest, fillet: tuple[float, float], *, sharp: bool) -> Dimension:
    found = [_end(views, crest, sign, fillet[0], sharp=sharp) for sign in (1.0, -1.0)]
    ends = [end for end, _ in found]
    steps = {"membrane": sum(e.steps["membrane"] for e in ends)}
    # Both ends have edges of the same radius, so that their errors add.
    common = fillet[1] * sum(share for _, share in found)
    return Dimension(sum(e.value for e in ends), math.hypot(common, *(e.sd for e in ends)), steps)


def _end(views: list[SolidView], crest: Crest, sign: float, fillet: float, *, sharp: bool) -> tuple[Dimension, float]:
    """Return how far an end of the crest is from its middle, m, by the views that show it, and its change over the fillet's radius."""
    top, found, beyonds = crest.top, [], []
    for view in views:
        profile = profile_of(view, top.middle, sign * top.along, BAND, 0.0, top.half[0] + 16e-3)
        try:
            bend = search_bend(profile, max(top.half[0] - 4e-3, 2e-3), top.half[0] + 4e-3)
        except IllConditioned:
            continue
        if abs(bend.near) < 0.15:
            beyond = beyond_end(bend, sharp=sharp, fillet=fillet)
            sd = math.hypot(bend.sd, SHARED)
            found.append(Dimension(bend.place + beyond.shift, sd, {"membrane": beyond.shift}))
            beyonds.append(beyond)
    if not found:
        raise IllConditioned("no view shows the membrane on both sides of an end of the crest; press nearer to it")
    end = pooled(found, SHARED)
    sd = float(np.mean([beyond.sd for beyond in beyonds]))  # of the correction, whose error all views share
    return Dimension(end.value, math.hypot(end.sd, sd), end.steps), float(np.mean([beyond.share for beyond in beyonds]))
