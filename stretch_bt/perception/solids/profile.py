"""A line of mean heights across a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.solids.views import SolidView

__all__ = ["HeightProfile", "profile_of"]

Array = npt.NDArray[np.float64]

STEP = 0.4e-3  # m, about a pixel of the hand's camera


@dataclass(frozen=True, slots=True)
class HeightProfile:
    """Mean heights (n,), m, at places (n,), m, along a line, of so many points each (n,); `noise`, m, is a point's standard deviation."""

    at: Array
    height: Array
    count: Array
    noise: float

    def between(self, low: float, high: float) -> HeightProfile:
        """Return the part of it between two places, m."""
        kept = (self.at >= low) & (self.at <= high)
        return HeightProfile(self.at[kept], self.height[kept], self.count[kept], self.noise)


def profile_of(view: SolidView, origin: Array, along: Array, band: float, low: float, high: float) -> HeightProfile:
    """Return the profile of a view from a world place (2,), m, along a unit direction (2,), over a strip `band` to either side."""
    away = view.points[:, :2] - origin[:2]
    at, across = away @ along, away @ np.array([-along[1], along[0]])
    inside = (np.abs(across) <= band) & (at >= low) & (at <= high)
    cells = np.floor((at[inside] - low) / STEP).astype(np.int64)
    count = np.bincount(cells)
    seen = count > 0
    means = [np.bincount(cells, values[inside])[seen] / count[seen] for values in (at, view.points[:, 2])]
    return HeightProfile(means[0], means[1], count[seen].astype(np.float64), view.noise)
