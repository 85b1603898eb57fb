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

SKIRT = 1.3  # rims away from the middle up to which the skirt is described by its curvature at the rim
CORE = 0.7  # rims from the middle that a start is taken from
CELLS = 500  # in which the cap and its skirt are averaged
LARGEST = 4.0  # times the contact as segmented, beyond which what is found is something else
ROUNDS = 10
STEPS = 8  # in a round: the rim need not be better than what the next round looks at
CLOSE = 0.3  # of the standard deviation of a mean: what an answer may still move by
SETTLED = 0.02  # relative change of the rim


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
    first = rim = _segmented(contact)
    for _ in range(ROUNDS):
        rim, before = _refined(contact.surface, rim), rim
        if max(abs(rim.a / before.a - 1.0), abs(rim.b / before.b - 1.0)) < SETTLED:
            break
    away = math.hypot((rim.x - first.x) / rim.a, (rim.y - first.y) / rim.b)
    if away > 1.0 or rim.a > LARGEST * first.a or rim.b > LARGEST * first.b:
        raise IllConditioned("the rim that the surface shows is not that of the contact")
    return rim


def _segmented(contact: Contact) -> Rim:
    """Return the ellipse with the middle and the extent of a contact."""
    places = contact.points[:, :2]
    (x, y), (a, b) = np.median(places, axis=0), 2.0 * places.std(axis=0)
    return Rim(float(x), float(y), float(a), float(b))


def _refined(surface: FloatArray, rim: Rim) -> Rim:
    """Return the rim after a fit to the surface within SKIRT of it; it may grow up to there."""
    size = math.hypot(rim.a, rim.b) / 2.0
    cells = rim.blocks(surface, SKIRT, CELLS)[:, :3]
    if len(cells) <= PARAMETERS:
        raise IllConditioned("there is hardly any surface around the contact")
    sight = sight_along_z(cells, (rim.x, rim.y), size)
    axes = np.array([rim.a, rim.b]) / size
    start = np.concatenate([_paraboloid(sight, CORE * axes), np.log(axes), np.zeros(2)])
    q = settled_surface(CapSurface(start, np.log(SKIRT * axes)), sight, "sphere", steps=STEPS, close=CLOSE).q
    a, b = np.exp(q[4:6]) * size
    return Rim(float(rim.x + q[6] * size), float(rim.y + q[7] * size), float(a), float(b))


def _paraboloid(sight: Sight, axes: Array) -> Array:
    """Return (c, p1, p2, k) of a convex paraboloid about the core of a contact, to start from."""
    core = (sight.x / axes[0]) ** 2 + (sight.y / axes[1]) ** 2 < 1.0
    x, y = sight.x[core], sight.y[core]
    if x.size <= PARAMETERS:
        raise IllConditioned("the contact is smaller than what its skirt can be told from")
    design = np.stack([np.ones_like(x), x, y, -0.5 * (x * x + y * y)])
    q, _ = robust_linear(design, sight.z[core], sight.floor, "sphere")
    q[3] = np.clip(q[3], 0.05, 0.9 / float(np.hypot(sight.x, sight.y).max()))
    return q
