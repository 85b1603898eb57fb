"""A camera's error in a height and in a size after pixels and frames are averaged, in closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import Size

__all__ = ["frames_left", "is_curved", "noise_sizes", "rim_slope"]

_SIDE = 0.045  # m; half the width of the shipped membrane
_HALF_RING = 4e-3  # m; so far from the rim on both sides the membrane is straight enough to locate its bend
_SKIRT = 6e-3  # m; about as far a smooth error passes for a bend of the skirt


def frames_left(memory: float, frames: int) -> float:
    """Return the standard deviation of a mean of frames over a single frame's; each keeps a share of the one before.

    The variance is (1 + 2 sum over k of (1 - k / n) memory^k) / n (Box, Jenkins and Reinsel, Time Series Analysis, 2.1.6).
    """
    if memory == 1.0:
        return 1.0
    n, r = frames, memory
    total = 1 + 2 * r / (1 - r) - 2 * r * (1 - r**n) / (n * (1 - r) ** 2)
    return math.sqrt(total / n)


def noise_sizes(case: Case, sd: float, kernel: float, why: str) -> Iterator[Size]:
    """Yield the errors of a height, a stiffness and a size by zero-mean noise of an image, as standard deviations over runs.

    Parameters
    ----------
    sd
        Standard deviation of a pixel in the mean over the frames, m.
    kernel
        Standard deviation of the Gaussian that smooths the white noise, pixels, so that 4 pi kernel^2 pixels share one error.
    """
    area, curved = _sharing(kernel), is_curved(case)
    radius = case.contact_radius if curved else case.radius
    count = math.pi * (radius / case.pixel) ** 2
    apart = math.sqrt(area / max(count, 1.0))
    # The vertex of a free quadratic over a disc has four times the variance of the mean.
    height = sd * min((2.0 if curved else 1.0) * apart, 1.0)
    said = f"{why}, {count:.0f} pixels in contact in groups of {area:.0f}"
    yield from case.from_height(height, said)
    bend = math.sqrt(0.5) * sd / max(kernel * case.pixel, 1e-9) ** 2  # sd of the mean curvature of such a field
    yield Size("size", _radius(case, sd * apart, bend) if curved else _diameter(case, sd, area, bend), said)


def _sharing(kernel: float) -> float:
    """Return how many pixels share one error of a smooth field: the sum over the plane of exp(-d^2 / 4 kernel^2), at least 1."""
    return max(4 * math.pi * kernel**2, 1.0)


def is_curved(case: Case) -> bool:
    """Return whether the object's top is round, or a flat face within an edge."""
    return case.rough.edge >= case.radius / 2


def rim_slope(case: Case) -> float:
    """Return how steep the skirt around a flat face begins, if it falls as a logarithm down to the sheet's side."""
    return case.depth / (case.radius * math.log(max(_SIDE / case.radius, 1.5)))


def _radius(case: Case, sd: float, bend: float) -> float:
    """Return the standard deviation of a cap's radius, m, from its curvature's, but for noise too smooth to be averaged.

    For averaged noise it is 2 sqrt(12) sd / sin^2 of the cap's half angle.
    """
    sine = min(case.contact_radius / case.radius, 1.0)
    return min(2 * math.sqrt(12) * sd / sine**2, bend * case.radius**2, case.radius)


def _diameter(case: Case, sd: float, area: float, bend: float) -> float:
    """Return the standard deviation of the diameter of a flat face, m: how well its rim's bend can be distinguished from noise."""
    slope = rim_slope(case)
    ring = 2 * math.pi * case.radius * 2 * _HALF_RING / case.pixel**2
    return min(4 * sd * math.sqrt(area / ring) / slope, 4 * _SKIRT**2 * bend / slope, case.radius)
