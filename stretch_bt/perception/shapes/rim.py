"""Where the membrane leaves a sphere: cap and skirt together say it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.blocks_kernel import blocks_within
from stretch_bt.perception.shapes.cap_surface import PARAMETERS, CapSurface
from stretch_bt.perception.shapes.robust_fit import robust_linear, settled_surface
from stretch_bt.perception.shapes.sight import Sight, sight_along_z
from stretch_bt.perception.types import Contact, FloatArray

__all__ = ["Rim", "find_rim"]

Array = npt.NDArray[np.float64]

SAMPLE = 500  # points of a contact that say where it is
WIDER = 1.4
SKIRT = 1.3  # rims away from the middle up to which the skirt is described by its curvature at the rim
CORE = 0.7  # rims from the middle that a start is taken from
CELLS = 350  # in which the cap and its skirt are averaged
LARGEST = 4.0  # times the contact as segmented, beyond which what is found is something else
ROUNDS = 15
STEPS = 4
CLOSE = 0.3  # of the standard deviation of a mean: what an answer may still move by
SETTLED = 0.05


@dataclass(frozen=True, slots=True)
class Rim:
    """Where a membrane leaves a sphere, seen along z: an ellipse about (x, y) with semi-axes a along i, b along j, m."""

    x: float
    y: float
    a: float
    b: float

    def blocks(self, surface: FloatArray, reach: float, most: int) -> Array:
        """Return the means, and how many pixels, (m, 4), of about `most` blocks of pixels within `reach` rims."""
        return np.asarray(blocks_within(surface, self.x, self.y, reach * self.a, reach * self.b, most))


def find_rim(contact: Contact) -> Rim:
    """Return where the membrane leaves a sphere, from the surface around a contact.

    Raises
    ------
    IllConditioned
        The surface around the contact does not tell where the rim is.
    """
    points = contact.points[:: max(1, len(contact.points) // SAMPLE)].astype(np.float64)
    origin, spread = np.median(points, axis=0), 2.0 * WIDER * points.std(axis=0)
    first = rim = Rim(float(origin[0]), float(origin[1]), float(spread[0]), float(spread[1]))
    size = math.hypot(rim.a, rim.b) / 2.0
    cap: CapSurface | None = None
    for _ in range(ROUNDS):
        cap = _refined(contact.surface, rim, origin, size, cap)
        rim, before = _rim_of(cap, origin, size), rim
        if max(abs(rim.a / before.a - 1.0), abs(rim.b / before.b - 1.0)) < SETTLED:
            break
    away = math.hypot((rim.x - first.x) / rim.a, (rim.y - first.y) / rim.b)
    if away > 1.0 or rim.a > LARGEST * first.a or rim.b > LARGEST * first.b:
        raise IllConditioned(
            "the surface bends around another place than the contact, so that its rim is not that of the contact; press one object at a"
            " time, away from the edges of the membrane"
        )
    return rim


def _rim_of(cap: CapSurface, origin: Array, size: float) -> Rim:
    (a, b), (x, y) = np.exp(cap.q[4:6]) * size, cap.q[6:] * size + origin[:2]
    return Rim(float(x), float(y), float(a), float(b))


def _refined(surface: FloatArray, rim: Rim, origin: Array, size: float, cap: CapSurface | None) -> CapSurface:
    """Return the cap after a fit to the surface within SKIRT of a rim, which may grow up to there."""
    cells = rim.blocks(surface, SKIRT, CELLS)[:, :3]
    if len(cells) <= PARAMETERS:
        raise IllConditioned(
            "hardly any pixel around the contact has depth, so that its rim is not seen; keep the membrane in view and free of"
            " reflections"
        )
    sight = sight_along_z(cells, origin, size)
    axes = np.array([rim.a, rim.b]) / size
    q = np.concatenate([_paraboloid(sight, CORE * axes), np.log(axes), np.zeros(2)]) if cap is None else cap.q
    return settled_surface(CapSurface(q, np.log(SKIRT * axes)), sight, "sphere", steps=STEPS, close=CLOSE)


def _paraboloid(sight: Sight, axes: Array) -> Array:
    """Return (c, p1, p2, k) of a convex paraboloid about the core of a contact, to start from."""
    core = (sight.x / axes[0]) ** 2 + (sight.y / axes[1]) ** 2 < 1.0
    x, y = sight.x[core], sight.y[core]
    if x.size <= PARAMETERS:
        raise IllConditioned(
            "the contact covers fewer cells than a sphere with its skirt has parameters; press deeper, or move the camera nearer"
        )
    design = np.stack([np.ones_like(x), x, y, -0.5 * (x * x + y * y)])
    q, _ = robust_linear(design, sight.z[core], sight.floor, "sphere")
    q[3] = np.clip(q[3], 0.05, 0.9 / float(np.hypot(sight.x, sight.y).max()))
    return q
