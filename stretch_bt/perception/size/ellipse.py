"""A contact with two axes, along i and j."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.hypothesis import FittedSizes
from stretch_bt.perception.size.round_shape import SMALLEST, RoundShape

__all__ = ["Ellipse"]

Array = npt.NDArray[np.float64]

UNLIKE = 0.04  # error of a diameter, as a share of it, per ln(aspect): the skirt's prior is made from round contacts
ASPECT_SD = 0.3  # of ln(diameter_i / diameter_j), over the objects there are


class Ellipse(RoundShape):
    """An elliptic contact with its axes along i and j."""

    name = "ellipse"
    radii = 2

    def radii_of(self, q: Array) -> tuple[float, float]:
        """Return the half axes, m."""
        return float(q[2]), float(q[3])

    def log_prior(self, q: Array) -> float:
        """Return the logarithm of the prior density, with the prior of the ratio of the axes as a density over the half axis along j."""
        ratio = math.log(q[2] / q[3]) / ASPECT_SD if min(q[2], q[3]) > 0.0 else math.inf
        second = max(abs(float(q[3])), SMALLEST)
        return super().log_prior(q) - 0.5 * ratio**2 - math.log(ASPECT_SD * math.sqrt(2.0 * math.pi) * second)

    def measure(self, q: Array, covariance: Array) -> FittedSizes:
        """Return the sizes; their sd grows with the ratio of the axes, as the prior is made from round contacts."""
        size = super().measure(q, covariance)
        share = UNLIKE * abs(math.log(q[2] / q[3]))
        (i, i_sd), (j, j_sd) = size.diameter_i, size.diameter_j
        return replace(size, diameter_i=(i, math.hypot(i_sd, share * i)), diameter_j=(j, math.hypot(j_sd, share * j)))
