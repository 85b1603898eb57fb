"""A sphere with the skirt of the membrane that it is pressed into."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.sphere_kernel import fill_cap

__all__ = ["PARAMETERS", "CapSurface"]

Array = npt.NDArray[np.float64]

PARAMETERS = 8
LARGEST_CHANGE = 0.25  # relative, of the rim in one step


@dataclass(frozen=True, slots=True)
class CapSurface:
    """A sphere inside an ellipse; outside it the membrane that leaves it there with the same slope and no mean curvature.

    `q` (8,) is (c, p1, p2, k) of a SphereSurface, the logarithms of the semi-axes along x and y, and the middle. Beyond
    the rim, along the ray from the middle, z continues by its second derivatives: those of the sphere plus a jump J n n
    across the rim's normal n, which continuity of slope leaves as the only one (Hadamard's compatibility condition),
    with J such that their trace vanishes, as it does on a membrane that nothing touches. `most` (2,) are the logarithms
    of the largest semi-axes.
    """

    q: Array
    most: Array

    @property
    def parameters(self) -> int:
        """How many parameters there are."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (8, n)."""
        height, jacobian = np.empty(x.size), np.empty((PARAMETERS, x.size))
        fill_cap(self.q, x, y, height, jacobian)
        return height, jacobian

    def moved(self, step: Array) -> tuple[CapSurface, Array]:
        """Return the surface after a step, shortened where the rim or the curvature would change by much."""
        _, _, _, k, a, b, _, _ = self.q.tolist()
        _, _, _, by_k, by_a, by_b, by_x, by_y = map(abs, step.tolist())
        change = max(by_a, by_b, by_x * math.exp(-a), by_y * math.exp(-b), 1e-300)
        share = min(1.0, LARGEST_CHANGE / change, 0.5 * max(abs(k), 0.05) / max(by_k, 1e-300))
        q = self.q + share * step
        np.minimum(q[4:6], self.most, out=q[4:6])
        return CapSurface(q, self.most), q - self.q
