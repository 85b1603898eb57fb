"""A body given by its height over a regular grid, as a depth camera or a drawing gives it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.indenters.base import Array, Gap, Solid, Zone, empty_gap, positive, spacing
from stretch_bt.source.arrays import load_array
from stretch_bt.source.bounds import MAX_FORM

__all__ = ["HeightField"]

_CROWN, _UPPER = (
    0.02,
    0.15,
)  # over half the grid: how far below the top counts as the top, and as the place that the sheet bends around
_RINGING = 0.5  # pitches
_PLANE = 4.0  # a top whose radius is this many half grids is flat


@dataclass(frozen=True, eq=False, repr=False)
class HeightField(Solid):
    """The ground under `heights` (rows along y, columns along x), m, on a square grid of `pitch`, m.

    The origin lies under the middle of the grid, at height 0. Between the nodes the surface is a bicubic spline without
    curvature across its border; there it ends in walls that go down, with a sharp edge, and beside it is nothing.
    The distance is that to the nearest point, where features are wider than an eighth of their distance.
    """

    heights: Array
    pitch: float
    #: whether there may be a second place nearly as near as that close to the point below
    winding: ClassVar[bool] = True

    def __post_init__(self) -> None:
        positive("the pitch of a height field", self.pitch)
        heights = np.array(self.heights, dtype=float)
        if heights.ndim != 2 or min(heights.shape) < 4:
            raise InvalidInput(f"a height field needs at least 4 x 4 nodes, not {heights.shape}")
        if not np.isfinite(heights).all():
            raise InvalidInput("a height field needs finite heights at all nodes")
        heights.flags.writeable = False
        object.__setattr__(self, "heights", heights)
        over = (self._middles.max() - self._nodes.max()) * self.pitch
        if over > _RINGING * self.pitch:
            raise InvalidInput(
                f"between nodes the smooth surface of a height field rises {over * 1e3:.2g} mm above the highest of them: "
                "it rings where heights jump; round the steps off, or sample them more finely"
            )

    @classmethod
    def load(cls, path: str | Path, pitch: float) -> HeightField:
        """Return the field in a .npy file of heights, m.

        Raises
        ------
        InvalidInput
            The file cannot be read, or holds something else.
        """
        try:
            heights = load_array(Path(path), MAX_FORM)
            if heights.dtype.kind not in "fiu":
                raise TypeError(f"it holds {heights.dtype}, not real numbers")
        except (OSError, InvalidInput, TypeError) as error:
            raise InvalidInput(f"{str(path)!r} is no .npy file of heights: {error}") from error
        return cls(heights, pitch)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, HeightField):
            return NotImplemented
        return self is other or (self.pitch == other.pitch and np.array_equal(self.heights, other.heights))

    def __hash__(self) -> int:
        return hash((self.pitch, self.heights.shape, self.heights.tobytes()))

    def __repr__(self) -> str:
        rows, columns = self.heights.shape
        return f"HeightField({columns} x {rows} nodes, pitch={self.pitch:g})"

    @cached_property
    def _nodes(self) -> Array:
        """Heights (ny, nx) in units of the pitch."""
        return np.ascontiguousarray(self.heights / self.pitch)

    @cached_property
    def _coefficients(self) -> Array:
        """Coefficients (ny + 2, nx + 2) of the natural cubic spline through the nodes."""
        along = _natural(self._nodes)
        return np.ascontiguousarray(_natural(np.ascontiguousarray(along.T)).T)

    @cached_property
    def _middles(self) -> Array:
        """Heights (ny - 1, nx - 1) in the middle of the cells, in units of the pitch."""
        weights = np.array([1.0, 23.0, 23.0, 1.0]) / 48
        rows = sum(w * self._coefficients[k : k + self.heights.shape[0] - 1] for k, w in enumerate(weights))
        return np.asarray(sum(w * rows[:, k : k + self.heights.shape[1] - 1] for k, w in enumerate(weights)))

    @cached_property
    def _middle(self) -> Array:
        """Place (3,) of the origin in units of the pitch from the first node."""
        rows, columns = self.heights.shape
        return np.array([(columns - 1) / 2, (rows - 1) / 2, 0.0])

    @cached_property
    def _half(self) -> float:
        """Half the shorter side of the grid, m."""
        return float(min(self.heights.shape) - 1) / 2 * self.pitch

    @cached_property
    def _bends(self) -> Array:
        """Larger principal curvature (ny, nx) of the surface at its nodes, 1/m, convex above 0; borders as within."""
        zy, zx = np.gradient(self.heights, self.pitch)
        zyy, zyx = np.gradient(zy, self.pitch)
        zxx = np.gradient(zx, self.pitch, axis=1)
        g = 1 + zx**2 + zy**2
        mean = -((1 + zy**2) * zxx - 2 * zx * zy * zyx + (1 + zx**2) * zyy) / (2 * g**1.5)
        gauss = (zxx * zyy - zyx**2) / g**2
        larger = mean + np.sqrt(np.maximum(mean**2 - gauss, 0.0))
        # one-sided differences at the border are not reliable
        return np.pad(larger[1:-1, 1:-1], 1, mode="edge")

    def _below_top(self, share: float) -> Array:
        return np.asarray(self.heights >= self.heights.max() - share * self._half)

    @cached_property
    def _tip(self) -> float:
        """Radius of curvature of its top, m."""
        return 1 / max(float(np.median(self._bends[self._below_top(_CROWN)])), 1e-3 / self._half)

    @cached_property
    def feature(self) -> float:
        """Radius, m, that all but the sharpest twentieth of its upper part exceed; at least the pitch."""
        sharp = float(np.percentile(self._bends[self._below_top(_UPPER)], 95))
        return max(1 / max(sharp, 1 / self.tip_radius), self.pitch)

    @property
    def tip_radius(self) -> float:
        """Radius of its top, m, at most half the grid."""
        return min(self._tip, self._half)

    @cached_property
    def flat(self) -> float:
        """Radius of the disc that has the area of its flat top, m; 0 where its top is round."""
        if self._tip < _PLANE * self._half:
            return 0.0
        return self.pitch * math.sqrt(int(self._below_top(_CROWN).sum()) / math.pi)

    def _crown(self, rotation: Array) -> Array:
        """Return the nodes (n, 3), m, that are highest after a rotation."""
        rows, columns = self.heights.shape
        u, v = np.meshgrid(np.arange(columns), np.arange(rows))
        places = (np.stack([u, v, self._nodes], axis=-1).reshape(-1, 3) - self._middle) * self.pitch @ rotation.T
        return np.asarray(places[places[:, 2] >= places[:, 2].max() - _CROWN * self._half])

    @property
    def peak(self) -> tuple[float, float]:
        """Place (x, y), m, of the node in the middle of its highest ones."""
        crown = self._crown(np.eye(3))
        places = crown[crown[:, 2] >= crown[:, 2].max() - 1e-3 * self.pitch, :2]
        x, y = places[np.argmin(np.linalg.norm(places - places.mean(axis=0), axis=1))].tolist()
        return x, y

    def crest(self, rotation: Array) -> tuple[float, float]:
        """Return how far its top reaches from the origin along x and y, m."""
        x, y, _ = np.abs(self._crown(rotation)).max(axis=0).tolist()
        return x, y

    def gap(self, points: Array) -> Gap:
        """Return distance, normal and curvature at points (n, 3), m."""
        from stretch_bt.simulation.membrane.indenters.height_kernel import ground

        gap = empty_gap(len(points))
        ground(points / self.pitch + self._middle, self._coefficients, self._nodes, self.winding, *gap)
        return Gap(gap.distance * self.pitch, gap.normal, gap.curvature / self.pitch)

    def at_border(self, points: Array, least: float) -> npt.NDArray[np.bool_]:
        """Return which points (n, 3), m, own frame, are within a pitch, or `least`, m, of the grid's border, or beside it."""
        inner = self._middle[:2] * self.pitch - max(self.pitch, least)
        return np.asarray((np.abs(points[:, :2]) > inner).any(axis=1))

    def top(self, rotation: Array) -> float:
        """Return the height of its highest point above the origin, m."""
        from stretch_bt.simulation.membrane.indenters.height_kernel import highest

        up = rotation[2]
        reached = float(highest(self._coefficients, self._nodes, *up.tolist()))
        return (reached - float(up @ self._middle)) * self.pitch

    def zones(self, rotation: Array, gauge: float) -> tuple[list[Zone], list[Zone]]:
        """Return its top and three elements around it."""
        size = min(spacing(self.tip_radius, gauge), 4 * spacing(self.feature, gauge))
        places = self._crown(rotation)
        low, high = places.min(axis=0) - 3 * size, places.max(axis=0) + 3 * size
        x, y = ([Zone(float(low[c]), float(high[c]), size)] for c in range(2))
        return x, y


def _natural(values: Array) -> Array:
    """Return coefficients (n, m + 2) of natural cubic splines through the rows of values (n, m), at whole places."""
    from scipy.linalg import solve_banded

    count = values.shape[1]
    bands = np.zeros((3, count))
    bands[0, 2:], bands[1], bands[2, :-2] = 1.0, 4.0, 1.0
    bands[1, [0, -1]] = 6.0
    inner = solve_banded((1, 1), bands, 6 * values.T).T
    first, last = 2 * inner[:, :1] - inner[:, 1:2], 2 * inner[:, -1:] - inner[:, -2:-1]
    return np.hstack([first, inner, last])
