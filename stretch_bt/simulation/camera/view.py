"""Where a camera stands, and which pixel sees which point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.perception.deprojection import ray_planes

__all__ = ["RIGHT", "SR305", "Offset", "View"]

SR305 = Intrinsics(fx=476.0, fy=476.0, cx=320.0, cy=240.0, width=640, height=480)

Array = npt.NDArray[np.float64]
_STEPS = 20
_MET = 1e-9  # of a unit of depth, a millionth of a pixel


class Offset(NamedTuple):
    """How a camera stands against where it is thought to: m, membrane frame, and rad.

    It is turned about the membrane's x axis first and then about its y axis, counter-clockwise seen from that axis' end.
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0


#: where it is thought to be
RIGHT = Offset()


@dataclass(frozen=True)
class View:
    """A camera at `plane_distance`, m, over the membrane's centre, but for its `offset`, with a lens.

    The image's x and y are those of the membrane frame, whose z is against the optical axis.
    """

    intrinsics: Intrinsics
    plane_distance: float
    offset: Offset = RIGHT

    def __post_init__(self) -> None:
        if not self.plane_distance + self.offset.z > 0:
            raise InvalidInput(f"a camera stands in front of the membrane, not {self.plane_distance:g} m from it")

    @cached_property
    def place(self) -> Array:
        """(3,) float, m, membrane frame."""
        return np.array([self.offset.x, self.offset.y, self.plane_distance + self.offset.z])

    @cached_property
    def turn(self) -> Array:
        """(3, 3) float: camera coordinates are `turn @ (point - place)`, depth last."""
        about_x = Pose(rotation=(self.offset.tilt_x, 0.0, 0.0)).matrix()
        about_y = Pose(rotation=(0.0, self.offset.tilt_y, 0.0)).matrix()
        seen: Array = np.diag([1.0, 1.0, -1.0]) @ (about_y @ about_x).T
        return seen

    @property
    def rays(self) -> tuple[Array, Array]:
        """X and y (h, w) float64 of the points that the pixels see at unit depth, camera frame."""
        x, y = ray_planes(self.intrinsics)
        return x, y

    def project(self, points: Array) -> Array:
        """Return (3, ...): column, row and depth, m, of the pixel that sees each point (..., 3), m, membrane frame.

        Points at a depth of 0 or less have no pixel; theirs mean nothing.
        """
        seen = np.moveaxis(points - self.place, -1, 0).reshape(3, -1)
        across, along, depth = (self.turn @ seen).reshape(3, *points.shape[:-1])
        depth_safe = np.where(depth > 0, depth, 1.0)
        x, y = self._bent(across / depth_safe, along / depth_safe)
        lens = self.intrinsics
        return np.stack([x * lens.fx + lens.cx, y * lens.fy + lens.cy, depth])

    def _bent(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Undo the lens: return what it takes to (x, y), by Newton's method with the slope of the radial part.

        Where the lens folds there is nothing, and what is returned lies far outside the image.
        """
        k1, k2, p1, p2, k3 = self.intrinsics.distortion
        if not any(self.intrinsics.distortion):
            return x, y
        u: Array = x.copy()
        v: Array = y.copy()
        for _ in range(_STEPS):
            r2 = u * u + v * v
            radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
            off_x = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u) - x
            off_y = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v) - y
            if max(np.abs(off_x).max(), np.abs(off_y).max()) < _MET:
                return u, v
            u -= off_x / radial
            v -= off_y / radial
        missed = np.hypot(off_x, off_y) > _MET
        u[missed] = v[missed] = 1e6
        return u, v
