"""A sphere with the skirt of the membrane that it is pressed into."""

from __future__ import annotations

from dataclasses import dataclass, replace

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
        change = max(float(np.abs(step[4:6]).max()), float(np.abs(step[6:] / np.exp(self.q[4:6])).max()))
        share = min(
            1.0,
            LARGEST_CHANGE / max(change, 1e-300),
            0.5 * max(abs(float(self.q[3])), 0.05) / max(abs(float(step[3])), 1e-300),
        )
        q = self.q + share * step
        q[4:6] = np.minimum(q[4:6], self.most)
        return replace(self, q=q), q - self.q
