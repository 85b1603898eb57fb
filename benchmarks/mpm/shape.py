"""How round a cloud of material points is, read as a reduced body of the same harmonics is."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from mpm.body import Body
from stretch_bt.perception.outlines.polyline import area_of, perimeter_of
from stretch_bt.perception.outlines.roundness import METHODS, contour_of
from stretch_bt.simulation.dough.directions import directions
from stretch_bt.simulation.dough.lump import Lump

__all__ = ["hull_volume", "lump_of", "pressed_circularity", "smoothed"]

Array = npt.NDArray[np.float64]

HARMONICS = 8
COUNT = 500
_ORDER = np.arange(HARMONICS + 1)
#: of harmonics up to 8, the highest of which is halved, so that what a corner leaves out does not ring
_WEIGHTS = (2 * _ORDER + 1) / (4 * math.pi) * 0.5 ** (_ORDER * (_ORDER + 1) / (HARMONICS * (HARMONICS + 1)))


def lump_of(body: Body) -> Lump:
    """Return the star-shaped body, of harmonics up to 8, whose fourth moments in every direction equal the points' moments.

    What is far out counts more, so that how the points within are spread does not matter.
    """
    inner = body.places - body.places.mean(axis=0)
    shares = body.contents * body.pitch**3
    inner -= shares @ inner / shares.sum()
    away = np.maximum(np.linalg.norm(inner, axis=1), 1e-12)
    return _star(inner / away[:, None], shares * away**2, body.edge**3)


def smoothed(lump: Lump) -> Lump:
    """Return a reduced body read in the same way."""
    vectors = lump.directions.vectors @ lump.rotation.T
    return _star(vectors, lump.radii**5 / 5 * lump.directions.solid_angle, lump.volume)


def _star(vectors: Array, moments: Array, volume: float) -> Lump:
    found = directions(COUNT)
    radii = np.empty(COUNT)
    for k, axis in enumerate(found.vectors):
        radii[k] = (5 * max(moments @ legendre.legval(vectors @ axis, _WEIGHTS), 0.0)) ** 0.2
    radii *= math.cbrt(volume / (np.sum(radii**3) * found.solid_angle / 3))
    return Lump(radii, np.array([1.0, 0.0, 0.0, 0.0]), volume)


def pressed_circularity(body: Body) -> float:
    """Return the circularity of the outline from above of a body that was pressed flat, of its first 8 harmonics."""
    flat = body.places[:, :2] - body.places[:, :2].mean(axis=0)
    away, azimuth = np.hypot(*flat.T), np.arctan2(flat[:, 1], flat[:, 0])
    shares = body.contents * away**2
    around = np.linspace(0, 2 * math.pi, 180, endpoint=False)
    order = np.arange(1, HARMONICS + 1)[:, None]
    along, across = (f(order * azimuth) @ shares for f in (np.cos, np.sin))
    fourth = shares.sum() / 2 + along @ np.cos(order * around) + across @ np.sin(order * around)
    radius = np.maximum(fourth, 0.0) ** 0.25
    line = np.column_stack([radius * np.cos(around), radius * np.sin(around)])
    curve = METHODS["low_pass"](contour_of(line))
    return 4 * math.pi * area_of(curve) / perimeter_of(curve) ** 2


def hull_volume(body: Body) -> float:
    """Return the volume of the convex hull of the points, each half a pitch large, over the cube's volume (Steiner's formula)."""
    from scipy.spatial import ConvexHull

    hull, half = ConvexHull(body.places), body.pitch / 2
    width = 4 * math.pi * math.cbrt(0.75 * hull.volume / math.pi)
    return float((hull.volume + hull.area * half + width * half**2 + 4 / 3 * math.pi * half**3) / body.edge**3)
