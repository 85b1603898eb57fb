"""Where a press needs small elements, and how stiff contact is on them."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.simulation.membrane.indenters.base import Zone, flatness, spacing
from stretch_bt.simulation.membrane.indenters.placed import Placed, place
from stretch_bt.simulation.membrane.sheet.error_law import relative_error
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.mesh import Mesh
from stretch_bt.simulation.membrane.sheet.result import Load, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["Layout"]

_SHALLOW = 2.0  # sheet units; a round tip pressed less than this touches less than the default elements resolve
_DRIFT = 1.5  # finest elements that a contact may move before the mesh follows
_OVER_EDGE = 1.0  # sheet units between an indenter's axis and the edge of the sheet
_OVER, _BESIDE = 0.010, 0.005  # relative error of the force of a body over an edge of the sheet, or beside it
_PLATE = 4.0  # stiffness of contact over the usual one where a plate gathers the pressure on a tip
_TIP = 3.0  # elements from the middle of a round tip to where the sheet leaves it
_SLACK = 0.003  # strain between the clamps

Zones = tuple[list[Zone], list[Zone]]


class Layout:
    """The bodies of a press in their places and their demands on the mesh; lengths in sheet units, `unit` in m."""

    def __init__(self, sheet: Sheet, load: Load, settings: Settings) -> None:
        self.sheet, self.load, self.settings = sheet, load, settings
        self.bodies: tuple[Placed, ...] = place(load.indenter, load.at, load.tilt, load.depth)
        self.span, self.unit = sheet.span(load.stretch), sheet.unit
        self.depth = load.travel / self.unit
        self.strain = self.span / 100 - 1
        self.slack = self.strain < _SLACK
        self.zones = [self._zones(body) for body in self.bodies]
        self._finest = [min(z.size for zones in pair for z in zones) for pair in self.zones]
        mesh = settings.mesh
        self.scale = settings.coarsen * (1.0 if mesh is None else mesh / self.unit / min(self._finest))

    def mesh(self) -> Mesh:
        """Return a mesh that is fine in every zone."""
        x, y = ([z._replace(size=z.size * self.scale) for pair in self.zones for z in pair[side]] for side in (0, 1))
        return self.sheet.outline.mesh(self.sheet.width / self.unit, x, y, self.settings.growth)

    def stiffnesses(self) -> list[float]:
        """Return each body's pressure per penetration: tension then settles over about one element at the contact's edge.

        A plate on a sharp tip gathers its pressure there, and is held by a stiffer contact.
        """
        factor = 4.5 * (self.scale**-2 if self.scale < 1 else 1 / self.scale)
        stiffer = [_PLATE ** (1 - _face(body)) if self._is_sharp(body) else 1.0 for body in self.bodies]
        return [factor * more / size**2 for more, size in zip(stiffer, self._finest, strict=True)]

    def _is_sharp(self, body: Placed) -> bool:
        """Whether a sheet that resists bending lies on a tip or an edge that is sharper than it is thick."""
        return self.sheet.effects.bending and body.indenter.feature < self.sheet.thickness

    def fits(self, start: SheetPress) -> bool:
        """Whether the mesh of an earlier press still suits this contact."""
        same = (start.load.indenter, start.load.tilt) == (self.load.indenter, self.load.tilt)
        same = same and start.settings.elements == self.settings.elements
        level = _refinement(start.load.travel / self.unit) == _refinement(self.depth)
        return same and level and self.drift(start) <= _DRIFT * start.shape.mesh.finest

    def drift(self, start: SheetPress) -> float:
        """Return how far the contact has moved over the unstretched sheet since the mesh of an earlier press was made."""
        old = self._rest(start.load.at, self.sheet.span(start.load.stretch))
        return start.memory.drift + float(np.abs(self._rest(self.load.at, self.span) - old).max())

    def _rest(self, at: tuple[float, float], span: float) -> Array:
        """Return the place (2,) on the unstretched sheet that a stretched one has over a place."""
        return np.multiply(at, self.sheet.outline.back(span / 100)) / self.unit

    @property
    def face(self) -> float:
        """How far the flattest body is one with a face, 0 to 1."""
        return max(map(_face, self.bodies))

    def error(self, nodes: int, added: float, across: float, sideways: float, overhang: float) -> float:
        """Return the estimated error of the force over the force; the arguments are as in `relative_error`."""
        return relative_error(
            self.scale,
            self.strain,
            nodes,
            face=max(map(_rim, self.bodies)),
            ridge=max(
                min(1.0, _length(b) / (_TIP * spacing(b.indenter.feature, self.sheet.gauge))) for b in self.bodies
            ),
            edge=self._edge(),
            sharp=any(self._is_sharp(body) for body in self.bodies),
            exact=self.settings.exact or self.settings.corrected,
            shallow=self.depth < _SHALLOW,
            tilted=self.load.tilt != (0.0, 0.0),
            added=added,
            across=across,
            sideways=sideways,
            overhang=overhang,
            has_friction=self.sheet.effects.friction > 0,
        )

    def _edge(self) -> float:
        """Return the relative error of the force by an edge of the sheet that is closer than the small elements or a depth."""
        halves = self.sheet.width / self.unit / 2, 50.0
        rooms = [
            (half - max(abs(z.low), abs(z.high)), half - abs(z.low + z.high) / 2)
            for pair in self.zones
            for zones, half in zip(pair, halves, strict=True)
            for z in zones
        ]
        if min(axis for _, axis in rooms) < _OVER_EDGE:
            return _OVER
        return _BESIDE if min(min(tip, axis - self.depth) for tip, axis in rooms) < 0 else 0.0

    def _zones(self, body: Placed) -> Zones:
        """Return zones on the unstretched sheet; widths and sizes are kept, places are carried back."""
        finer = 0.5 ** (_refinement(self.depth) * (1 - _face(body)))
        back = self.sheet.outline.back(self.span / 100)
        x, y = (
            [_zone(z, shrink, finer, self.unit) for z in zones]
            for zones, shrink in zip(body.zones(self.sheet.gauge), back, strict=True)
        )
        return x, y


def _face(body: Placed) -> float:
    return flatness(body.indenter.flat, body.indenter.feature)


def _rim(body: Placed) -> float:
    """Return how far the error of a body's force is one of a face and rim; a ridge counts half, for the rims at its ends."""
    face = _face(body)
    return face + (1 - face) * flatness(_length(body), body.indenter.feature) / 2


def _length(body: Placed) -> float:
    """Return half the length of a ridge, m, past its width; 0 for a tip or a face that is as wide as long."""
    x, y = body.indenter.crest(body.rotation)
    return abs(x - y)


def _zone(zone: Zone, shrink: float, finer: float, unit: float) -> Zone:
    middle, half = shrink * (zone.low + zone.high) / 2, (zone.high - zone.low) / 2 * finer
    return Zone((middle - half) / unit, (middle + half) / unit, zone.size * finer / unit)


def _refinement(depth: float) -> int:
    """Return how often the elements are halved for a press as shallow as `depth`, sheet units."""
    return max(0, math.ceil(math.log2(math.sqrt(_SHALLOW / depth)) - 1e-9))
