"""A round contact."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.size.round_shape import RoundShape

__all__ = ["Circle"]

Array = npt.NDArray[np.float64]


class Circle(RoundShape):
    """A round contact: the fillet and the steeper skirt along i make its hinge a little longer along i than along j."""

    name = "circle"
    radii = 1

    def radii_of(self, q: Array) -> tuple[float, float]:
        """Return the radius twice, m."""
        return float(q[2]), float(q[2])
