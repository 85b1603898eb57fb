"""The shape of an object from the contacts felt on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_each, check_kind, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact, shown
from stretch_bt.perception.clouds.cloud import Cloud
from stretch_bt.perception.clouds.dimensions import measure_object
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.perception.clouds.stand_off import HANG_SD
from stretch_bt.perception.solids.agree import SURFACES, Surface, contradiction, surface_of_domes, surface_of_points
from stretch_bt.perception.solids.block import block, disc
from stretch_bt.perception.solids.conformity import FILLET, FILLET_SD
from stretch_bt.perception.solids.crest import (
    crest_of,
    evidence_of_crest,
    half_cylinder,
    ridge,
    unlike_crest,
    unlike_half_cylinder,
)
from stretch_bt.perception.solids.domes import domes, domes_of, evidence_of_domes, point, radii_of
from stretch_bt.perception.solids.outline import Fitted, outlines, rays_of
from stretch_bt.perception.solids.result import KINDS, Dimension, Kind, Solid, Weighed
from stretch_bt.perception.solids.top import Top, height_map, peaks_of, top_of
from stretch_bt.perception.solids.unlike import unlike_circle, unlike_rectangle
from stretch_bt.perception.solids.views import SolidView, views_of
from stretch_bt.perception.solids.wire import is_hollow, wire_circle, wire_triangle
from stretch_bt.perception.types import CLOUD, MADE, Contact

__all__ = ["fit_object"]

Array = npt.NDArray[np.float64]
Made = Callable[[], Mapping[str, Dimension]]

LOWEST = 2e-3  # m above the lowest hand from which a peak counts
RIVAL = 12.0  # nats of evidence that a shape may lack on the best and still stand in for one that cannot be measured
FAMILY = {
    **dict.fromkeys(("block", "disc", "wire_circle", "wire_triangle"), "flat"),
    **dict.fromkeys(("ridge", "half_cylinder"), "crest"),
    **dict.fromkeys(("domes", "point"), "round"),
}
MARGIN = 10e-3  # m beyond the top within which its outline is sought


class _Case:
    """The data by which all kinds of shapes are judged."""

    def __init__(
        self, views: list[SolidView], cloud: Cloud, fillet: tuple[float, float], relief: Relief | None
    ) -> None:
        self.views, self.cloud, self.fillet, self.relief = views, cloud, fillet, relief
        self.floor = math.hypot(cloud.floor, HANG_SD)
        self.heights = height_map(views)
        self.top: Top = top_of(self.heights)
        self.heading = math.atan2(float(self.top.along[1]), float(self.top.along[0]))
        self.middle: Array = self.top.middle
        self.made: dict[Kind, Made] = {}
        self.stands: dict[Kind, tuple[Array, float]] = {}
        self.surfaces: dict[Kind, Surface] = dict(SURFACES)
        self.evidence: dict[Kind, float] = {}
        self.refused: dict[Kind, str] = {}
        self.unlike: dict[Kind, str] = {}

    def offer(self, kind: Kind, evidence: float, made: Made, at: tuple[Array, float] | None = None) -> None:
        """Offer a kind, with its middle (2,), m, world, and its heading, rad, where these differ from the top's."""
        self.evidence[kind], self.made[kind] = evidence, made
        self.stands[kind] = at or (self.middle, self.heading)

    def agreed(self, kind: Kind) -> Mapping[str, Dimension]:
        """Return the dimensions of a kind; raises IllConditioned also where the presses showed that it is another."""
        if why := self.unlike.get(kind):
            raise IllConditioned(why)
        found = self.made[kind]()
        if self.relief is None:
            return found
        if why := contradiction(kind, self.surfaces[kind], found, self.relief, *self.stands[kind]):
            raise IllConditioned(why)
        return found


def fit_object(
    cloud: Cloud,
    contacts: Sequence[Contact],
    *,
    shape: str = "auto",
    fillet: float = FILLET,
    fillet_sd: float = FILLET_SD,
    relief: Relief | None = None,
) -> Solid:
    """Fit the shape of an object on the table to what contacts show of it, and return its dimensions.

    The form of the top chooses among families: flat, a crest, or round. Within one the shapes are compared by their
    evidence. The best one that can be measured, and that agrees with the map of the presses, is taken, then a flat shape that is
    about as likely; where there is none, the extents of the cloud are returned.

    Parameters
    ----------
    cloud : Cloud
        The contacts fused, in the world.
    contacts : sequence of Contact
        Those that the cloud was fused from, with the pose of the hand.
    shape : str
        A kind of shape to take for granted, or "auto".
    fillet, fillet_sd : float, m
        Radius of the object's edges, or of its wire, with its standard deviation.
    relief : Relief, optional
        The map of the presses. A shape that is taken for granted is not compared with it.

    Raises
    ------
    NoContact
        Cloud or contacts are empty.
    IllConditioned
        The shape that was asked for cannot be measured, with the reason; or nothing can.
    InvalidInput
        The cloud or a contact is not in the world, or an argument has a wrong value.
    """
    check_kind("cloud", cloud, Cloud, CLOUD)
    check_each("contacts", contacts, Contact, MADE)
    if relief is not None:
        check_kind("relief", relief, Relief)
    check_numbers("in m", fillet=fillet, fillet_sd=fillet_sd)
    if not isinstance(shape, str) or shape not in ("auto", *KINDS):
        raise InvalidInput(f"shape is 'auto' or one of {', '.join(KINDS)}, got {shown(shape)[:80]}")
    if not (0 < fillet < 0.02 and 0 <= fillet_sd < 0.02):
        raise InvalidInput(f"fillet is a radius in m, from 0 to 0.02, got {fillet} +- {fillet_sd}")
    if cloud.frame != "world":
        raise InvalidInput("a shape on the table takes a cloud in the world; this one is in the frame of the hand")
    if not len(cloud):
        raise NoContact("the cloud has no point: nothing was felt; press the object first")
    views = views_of(contacts)
    try:
        case = _Case(views, cloud, (fillet, fillet_sd), relief)
    except IllConditioned as error:
        if shape not in ("auto", "extents"):
            raise
        return _extents(cloud, [Weighed("extents", 0.0)], str(error))
    other = case.top.another
    if other is not None and case.top.evidence["round"] < 0.0:
        raise IllConditioned(
            f"there are two tops as high, {_millimetres(case.middle)} and {_millimetres(other)}: measure separate objects one"
            " at a time, each with its own contacts"
        )
    _flat(case)
    _crest(case)
    _round(case)
    return _best(case, shape)


def _millimetres(place: Array) -> str:
    return f"({place[0] * 1e3:.0f}, {place[1] * 1e3:.0f}) mm"


def _flat(case: _Case) -> None:
    """Offer block, disc and wires."""
    top, family = case.top, case.top.evidence["flat"]
    kinds: tuple[Kind, ...] = ("block", "disc", "wire_circle", "wire_triangle")
    if family < -50.0:
        case.refused.update(dict.fromkeys(kinds, "the top is not flat"))
        return
    try:
        rays = rays_of(case.views, top.middle, max(top.half) + MARGIN)
    except IllConditioned as error:
        case.refused.update(dict.fromkeys(kinds, str(error)))
        return
    fits: dict[str, Fitted] = {fitted.name: fitted for fitted in outlines(rays.places)}
    best = max(f.evidence for f in fits.values())
    round_ = unlike_circle(rays.places, fits["circle"])
    case.unlike["disc"] = case.unlike["wire_circle"] = round_
    case.unlike["block"] = unlike_rectangle(rays.places, fits["rectangle"])
    size = float(np.median(np.hypot(*(rays.places - top.middle).T)))
    hollow = is_hollow(case.views, top.middle, size)
    floor, fillet, views = case.floor, case.fillet, case.views

    def offer(kind: Kind, name: str, made: Made, *, wire: bool) -> None:
        outline = fits[name]
        turn = math.pi / 2 if name == "rectangle" and outline.sizes[1] > outline.sizes[0] else 0.0
        evidence = family + outline.evidence - best - (0.0 if wire is hollow else 5.0)
        case.offer(kind, evidence, made, (outline.middle, outline.heading + turn))

    offer("block", "rectangle", lambda: block(views, fits["rectangle"], floor, fillet), wire=False)
    offer("disc", "circle", lambda: disc(views, fits["circle"], floor, fillet), wire=False)
    offer("wire_circle", "circle", lambda: wire_circle(rays, floor, fillet), wire=True)
    offer("wire_triangle", "triangle", lambda: wire_triangle(views, fits["triangle"], floor, fillet), wire=True)


def _crest(case: _Case) -> None:
    """Offer ridge and half-cylinder."""
    family = case.top.evidence["crest"]
    # A round top is a crest too, a short one, and a long crest whose ends are in view may be taken for round.
    longish = 0.0 if case.top.half[0] > 2.0 * case.top.half[1] else -8.0
    try:
        crest = crest_of(case.views, case.top)
    except IllConditioned as error:
        case.refused.update({"ridge": str(error), "half_cylinder": str(error)})
        return
    case.unlike["half_cylinder"], case.unlike["ridge"] = unlike_half_cylinder(crest), unlike_crest(crest)
    evidence, floor = evidence_of_crest(crest), case.floor
    case.offer("ridge", family + longish + evidence["ridge"], lambda: ridge(case.views, crest, floor, case.fillet))
    case.offer(
        "half_cylinder",
        family + longish + evidence["half_cylinder"],
        lambda: half_cylinder(case.views, crest, floor, case.fillet),
    )


def _round(case: _Case) -> None:
    """Offer domes and a point."""
    family = case.top.evidence["round"]
    low = min(float(view.hand[2]) for view in case.views) + LOWEST
    try:
        found = domes_of(case.views, peaks_of(case.heights, case.views, low))
    except IllConditioned as error:
        case.refused.update({"domes": str(error), "point": str(error)})
        return
    short = 0.0 if case.top.half[0] <= 2.0 * case.top.half[1] else -8.0
    evidence, floor = evidence_of_domes(found), case.floor
    stands = case.middle, case.heading
    case.surfaces["domes"] = surface_of_domes(found, radii_of(found, floor), *stands)
    case.surfaces["point"] = surface_of_points(found, *stands)
    case.offer("domes", family + short + evidence["domes"], lambda: domes(found, floor))
    case.offer("point", family + short + evidence["point"], lambda: point(found, floor))


def _best(case: _Case, shape: str) -> Solid:
    """Return the first kind by evidence that can be measured."""
    order = sorted(case.evidence, key=lambda kind: -case.evidence[kind])
    most = case.evidence[order[0]] if order else 0.0
    family = max(case.top.evidence, key=lambda name: case.top.evidence[name])
    asked = [kind for kind in order if kind == shape]
    if shape == "auto":
        likely = [kind for kind in order if case.evidence[kind] > most - RIVAL]
        # a membrane that resists bending spans a flat top as a saddle, and a small one then looks like a crest
        asked = [k for k in likely if FAMILY[k] == family] + [k for k in likely if FAMILY[k] == "flat" != family]
    chosen: tuple[Kind, Mapping[str, Dimension]] | None = None
    for kind in asked:
        try:
            chosen = kind, case.agreed(kind) if shape == "auto" else case.made[kind]()
            break
        except IllConditioned as error:
            case.refused[kind] = str(error)
    ranking = [Weighed(kind, case.evidence[kind] - most, case.refused.get(kind, "")) for kind in order]
    ranking += [Weighed(kind, None, why) for kind, why in case.refused.items() if kind not in case.evidence]
    if chosen is None:
        reasons = "; ".join(f"{w.kind}: {w.refused}" for w in ranking if w.refused and shape in ("auto", w.kind))
        if shape not in ("auto", "extents"):
            raise IllConditioned(
                f"no {shape} fits what was felt: {reasons or 'the top is of another kind'}; press at more places, or leave the shape open"
            )
        return _extents(case.cloud, ranking, reasons)
    kind, dimensions = chosen
    again = 2 * math.pi / 3 if kind == "wire_triangle" else math.pi
    (x, y), heading = case.stands[kind]
    heading = (heading + again / 2) % again - again / 2
    return Solid(kind, dimensions, float(x), float(y), dimensions["height"].value, heading, tuple(ranking))


def _extents(cloud: Cloud, ranking: list[Weighed], why: str) -> Solid:
    """Return the extents of a cloud as the dimensions of no shape in particular."""
    found = measure_object(cloud)
    named = zip(("length", "width", "height"), found.lengths, found.sd, found.short, strict=True)
    # how far an extent falls short is known no better than by half of it
    dimensions = {
        name: Dimension(float(v + short / 2), float(math.hypot(sd, short / 2)), {"membrane": float(short / 2)})
        for name, v, sd, short in named
    }
    x, y = np.median(cloud.points[:, :2], axis=0).tolist()
    heading = math.atan2(float(found.axes[0, 1]), float(found.axes[0, 0]))
    heading = (heading + math.pi / 2) % math.pi - math.pi / 2
    first = Weighed("extents", 0.0, why)
    others = tuple(w for w in ranking if w.kind != "extents")
    return Solid("extents", dimensions, x, y, dimensions["height"].value, heading, (first, *others))
