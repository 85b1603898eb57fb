"""How far a membrane that resists bending stands above a flat top: its edges lift it, and it spans the rest as a drum."""

from __future__ import annotations

import math

import numpy as np

from stretch_bt.errors import InvalidInput, NoContact
from stretch_bt.perception.top import Points, Top, disc_of
from stretch_bt.perception.types import CONTACT, FloatArray, LabelArray
from stretch_bt.units import Estimate

__all__ = ["lift_of_flat", "lift_off"]

# Over 300 discs and blocks of 12 to 40 mm with edges of 0.5 to 10 mm under the solved sheet, 1 and 2 mm thick, pressed 3 to 14 mm deep at
# stretches of 0 to 60 mm (`python -m benchmarks.lift_off`): the powers of depth, thickness, strain and half the size, all in m, the
# factor, and the standard deviation as a part of it.
FACTOR, DEPTH, THICKNESS, STRAIN, SIZE = 5.54, 0.855, 1.355, -0.368, -0.429
PART = 0.4
SLOPE = 40.0  # 1/m; slope of the skirt over the depth of the press: a round top whose membrane leaves it without a bend has it at its rim
INSIDE = 0.75  # of the contact's radius, within which its curvature is told
MOST, LEAST = 4000, 30  # points of the contact that are looked at; of fewer the top may be flat or round
SHALLOW, SMALL = 1e-3, 3e-3  # m; the law is not asked for less depth, or for a smaller contact whose shape is not seen


def lift_of_flat(height: float, radius: float, thickness: float, strain: float) -> float:
    """Return how far the membrane stands above a flat top whose contact has a radius, m."""
    return float(FACTOR * height**DEPTH * thickness**THICKNESS * strain**STRAIN * radius**SIZE)


def lift_off(points: FloatArray, labels: LabelArray, height: float, thickness: float, strain: float) -> Estimate:
    """Return how far the membrane stands above the top of what it touches, m: none over a round top, all of it over a flat one.

    Parameters
    ----------
    points : (h, w, 3) float, m, membrane frame
    labels : (h, w) uint8
        Classes as `segment` gives them.
    height : m
        That of the membrane's top above its clamps.
    thickness : m
        Of the membrane.
    strain
        By which the free membrane is stretched in its mounts, above 0.

    Raises
    ------
    InvalidInput
        Thickness or strain is not above 0.
    NoContact
        No point in contact has depth.
    """
    if not (thickness > 0.0 and strain > 0.0):
        raise InvalidInput(f"thickness and strain must be above 0, not {thickness} m and {strain}")
    cloud = points.reshape(-1, 3)[labels.reshape(-1) == CONTACT]
    cloud = cloud[np.isfinite(cloud).all(axis=1)][:: max(1, len(cloud) // MOST)].astype(np.float64).T
    if not cloud.size:
        raise NoContact("no point in contact has depth, so that no top is seen; press deeper")
    middle, away, radius = disc_of(cloud)
    depth, radius = max(height, SHALLOW), max(radius, SMALL)
    most = lift_of_flat(depth, radius, thickness, strain)
    near = np.ascontiguousarray(cloud[:, away <= (INSIDE * radius) ** 2])
    if near.shape[1] < LEAST:
        return Estimate(0.5 * most, 0.5 * most)
    top = Top(Points(near, np.arange(near.shape[1])), middle, even=True)
    tangent = SLOPE * depth / radius
    flat = min(max(1.0 - top.curvature / tangent, 0.0), 1.0)
    unsure = top.curvature_sd / tangent
    return Estimate(flat * most, most * min(math.hypot(PART * flat, unsure), 1.0))
