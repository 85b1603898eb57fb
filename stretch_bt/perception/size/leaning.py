"""A flat face that leans, where the labels, or the shape that fits, may hold its high side alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.leaning import STEEPEST
from stretch_bt.perception.leaning_face import BESIDE, MOST_CELLS, PAST, Around, Face, face_around
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.correlation import correlation_area
from stretch_bt.perception.size.start import HIGH, Start
from stretch_bt.perception.types import MaskArray
from stretch_bt.units import Estimate

__all__ = ["NO_LEAN", "FaceBeside", "face_beside"]

Array = npt.NDArray[np.float64]

SPREAD = 0.55  # standard deviation of the places in a face along an axis, over half its length
POWER = 4.0  # of the face's outline
LEAST_CELLS = 20  # of a contact
BY_CHANCE = 2.0  # standard deviations of the height of a contact: of the slope of the membrane around times its radius
LEANS = 2.0  # standard deviations of the slope of a contact beyond which it leans
INNER = 0.7  # share of the radius of a contact that lies in the plane of its face
# Standard deviation of a width or a height, as a part of the difference from the face's; of a width, and of a height, over the slope of the
# membrane around times the contact's radius, where this shows no face (`python benchmarks/leaning_tops.py --sizes`)
OFF, UNSEEN, UNSEEN_DEPTH = 0.7, 20.0, 3.0


@dataclass(frozen=True, slots=True)
class FaceBeside:
    """The `face` that the membrane around a contact shows, in the places of the cells; None where it shows none, but leans by `askew`, m."""

    face: Face | None
    askew: float

    def start(self) -> Start | None:
        """Return where fits of a shape begin."""
        if self.face is None:
            return None
        a, b, turn = *self.face.half, self.face.turn
        long, short, angle = (a, b, turn) if a > b else (b, a, turn + math.pi / 2.0)
        across, along = (SPREAD * math.hypot(long * w, short * v) for w, v in _turned(angle))
        x, y = self.face.middle
        return Start(float(x), float(y), self.face.height, across, along, SPREAD * long, SPREAD * short, angle)

    def off(self, i: float, j: float, depth: float) -> tuple[float, float, float]:
        """Return how far off widths along i and j and a depth may be, m, since they may be those of the high side of a face."""
        if self.face is None:
            return UNSEEN * self.askew, UNSEEN * self.askew, UNSEEN_DEPTH * self.askew
        a, b = self.face.half
        widths = (
            2.0 * ((abs(w) / a) ** POWER + (abs(v) / b) ** POWER) ** (-1.0 / POWER) for w, v in _turned(self.face.turn)
        )
        wide_i, wide_j = widths
        return OFF * abs(wide_i - i), OFF * abs(wide_j - j), OFF * abs(self.face.height - depth)


NO_LEAN = FaceBeside(None, 0.0)


def _turned(angle: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the directions of x and y along axes that are turned by an angle, rad."""
    c, s = math.cos(angle), math.sin(angle)
    return (c, s), (s, c)


def face_beside(cells: HeightCells, top: float) -> FaceBeside:
    """Return the face that the membrane around a contact shows, whose top is at a height, m."""
    import cv2

    there = cells.valid & (cells.touching > 0.5) & (cells.height > HIGH * top)
    n = int(np.count_nonzero(there))
    if n < LEAST_CELLS:
        return NO_LEAN
    places = np.stack([cells.x, cells.y, cells.height], axis=2)
    contact, radius = np.median(places[there], axis=0), math.sqrt(n * cells.area / math.pi)
    away = np.hypot(cells.x - contact[0], cells.y - contact[1])
    inner = cv2.erode(there.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    plane = _plane(places - contact, inner & (away < INNER * radius)) or _plane(places - contact, there)
    if plane is None:
        return NO_LEAN
    slopes, slope_sd, sd = plane
    around = Around(radius, Estimate(float(contact[2]), sd), (slopes, slope_sd))
    near = cells.valid & (away < BESIDE * radius + PAST)
    some = places[near][:: -(-int(np.count_nonzero(near)) // MOST_CELLS)]
    face, askew = face_around(some - [contact[0], contact[1], 0.0], around, BY_CHANCE * sd)
    if face is None:
        leans = LEANS * slope_sd < float(np.hypot(*slopes)) < STEEPEST  # a steeper contact holds skirt on one side
        return FaceBeside(None, askew) if leans else NO_LEAN
    return FaceBeside(Face(face.height, face.slopes, face.middle + contact[:2], face.half, face.turn), 0.0)


def _plane(places: Array, inner: MaskArray) -> tuple[Array, float, float] | None:
    """Return the slopes (2,) of the plane through places (rows, columns, 3), m, of a mask, with the standard deviation of the less sure one.

    And the standard deviation of its height, m; None of too few places.
    """
    x, y, z = places[inner].T
    n = z.size
    if n < LEAST_CELLS:
        return None
    a = np.stack([np.ones(n), x - x.mean(), y - y.mean()])
    q = np.linalg.lstsq(a.T, z, rcond=None)[0]
    left = np.zeros(inner.shape)
    left[inner] = z - q @ a
    area = min(correlation_area(left, inner), n / (2.0 * len(a)))
    variance = float(np.sum(left * left)) / (n - len(a) * area) * area
    slopes: Array = q[1:].astype(np.float64)
    least = float(np.linalg.eigvalsh(a[1:] @ a[1:].T)[0])
    return slopes, math.sqrt(variance / max(least, 1e-30)), math.sqrt(variance / n)
