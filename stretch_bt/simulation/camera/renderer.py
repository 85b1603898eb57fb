"""What a depth camera above the membrane sees: the deformed sheet, the table beside it, and noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.membrane.surface import Surface
from stretch_bt.simulation.scene import CameraNoise

__all__ = ["SR305", "DepthRenderer", "add_noise"]

SR305 = Intrinsics(fx=476.0, fy=476.0, cx=320.0, cy=240.0, width=640, height=480)

Image = npt.NDArray[np.float32]
_SAMPLES = 2048
_NEWTON_STEPS = 3


class DepthRenderer:
    """Renders depth along the optical axis, m, of a camera over the centre of the membrane; 0 is no value.

    The table shows beside the free sides of the sheet; its ends hide under the fingers, which give no value.
    """

    def __init__(self, intrinsics: Intrinsics, plane_distance: float, gauge: float, width: float) -> None:
        self.intrinsics = intrinsics
        self.distance = plane_distance
        self.gauge = gauge
        self._x = ((np.arange(intrinsics.width) - intrinsics.cx) / intrinsics.fx).astype(np.float32)
        self._y = ((np.arange(intrinsics.height) - intrinsics.cy) / intrinsics.fy).astype(np.float32)
        self._columns = _between(self._x * plane_distance, -width / 2, width / 2)

    def render(self, surface: Surface | None, axis: tuple[float, float], stretch: float, hand_height: float) -> Image:
        """Return the (h, w) float32 depth, m, without noise.

        Parameters
        ----------
        surface
            Shape of the membrane around the object's axis, or None when flat.
        axis
            Where the object's axis pierces the membrane, membrane frame, m.
        stretch
            Stretch of the membrane, m.
        hand_height
            World height of the flat membrane, m; the table lies that far behind it.
        """
        depth: Image = np.zeros((self.intrinsics.height, self.intrinsics.width), np.float32)
        half = (self.gauge + stretch) / 2
        rows = _between(self._y * self.distance, -half, half)
        depth[rows] = max(self.distance + hand_height, 0.0)
        depth[rows, self._columns] = self.distance
        if surface is not None and np.isinf(surface.span):
            depth[rows, self._columns] = self.distance - surface.depth
        elif surface is not None:
            self._indent(depth, surface, axis, rows)
        return depth

    def _indent(self, depth: Image, surface: Surface, axis: tuple[float, float], rows: slice) -> None:
        """Replace the flat membrane by the deformed one around the axis."""
        reach = surface.span * 1.001
        v = _overlap(rows, _between(self._y * self.distance, axis[1] - reach, axis[1] + reach))
        u = _overlap(self._columns, _between(self._x * self.distance, axis[0] - reach, axis[0] + reach))
        if v.start < v.stop and u.start < u.stop:
            depth[v, u] = _intersect(self._x[None, u], self._y[v, None], axis, self.distance, surface)


def _intersect(x: Image, y: Image, axis: tuple[float, float], distance: float, surface: Surface) -> Any:
    """Return the depth at which each ray (x, y, 1) meets the surface, by Newton on a table of its profile."""
    count = _SAMPLES / (surface.span * 1.1)
    table = surface.height(np.arange(_SAMPLES + 2) / count)
    heights = table[:-1].astype(np.float32)
    slopes = (np.diff(table) * count).astype(np.float32)
    d: Any = np.full(np.broadcast_shapes(x.shape, y.shape), distance - surface.depth / 2, np.float32)
    nearest, farthest = np.float32(distance - surface.depth), np.float32(distance)
    ax, ay = np.float32(axis[0]), np.float32(axis[1])
    for _ in range(_NEWTON_STEPS):
        px, py = x * d - ax, y * d - ay
        r = np.sqrt(px * px + py * py)
        position = np.minimum(r * np.float32(count), np.float32(_SAMPLES))
        index = position.astype(np.int32)
        slope = slopes.take(index)
        z = heights.take(index) + slope * (position - index) / np.float32(count)
        rate = 1 + slope * (px * x + py * y) / np.maximum(r, np.float32(1e-9))
        d = d - (d + z - farthest) / np.maximum(rate, np.float32(0.2))
        np.clip(d, nearest, farthest, out=d)
    return d


def add_noise(depth: Image, noise: CameraNoise, random: np.random.Generator) -> npt.NDArray[np.uint16]:
    """Return the (h, w) uint16 counts of `noise.quantisation` that the camera sends for a depth image, m."""
    seen = depth > 0
    if noise.noise > 0:
        depth = depth + random.standard_normal(depth.shape, np.float32) * np.float32(noise.noise)
    counts = np.rint(depth * np.float32(1 / noise.quantisation))
    np.clip(counts, 0, 65535, out=counts)
    if noise.dropout > 0:
        seen &= random.random(depth.shape, np.float32) >= noise.dropout
    counts[~seen | (counts == 65535)] = 0
    raw: npt.NDArray[np.uint16] = counts.astype(np.uint16)
    return raw


def _between(values: Any, low: float, high: float) -> slice:
    """Return the slice of rising values that lie between two bounds."""
    first, last = np.searchsorted(values, (low, high), side="left")
    return slice(int(first), int(last))


def _overlap(one: slice, other: slice) -> slice:
    return slice(max(one.start, other.start), min(one.stop, other.stop))
