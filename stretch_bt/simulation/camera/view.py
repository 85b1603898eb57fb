"""Where a camera stands, and which pixel sees which point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.perception.deprojection import ray_planes

__all__ = ["RIGHT", "SR305", "CameraView", "Offset"]

SR305 = Intrinsics(fx=476.0, fy=476.0, cx=320.0, cy=240.0, width=640, height=480)

Array = npt.NDArray[np.float64]


class Offset(NamedTuple):
    """Offset of a camera from its assumed place: m, membrane frame, and rad.

    It is turned about the membrane's x axis first and then about its y axis, by the usual matrices; in the membrane frame, which is left-handed,
    that is clockwise seen from the axis' end.
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0


#: at its assumed place
RIGHT = Offset()


@dataclass(frozen=True)
class CameraView:
    """A camera at `plane_distance`, m, over the membrane's centre, but for its `offset`, with a lens.

    The image's x and y are the membrane frame's, whose z is against the optical axis.
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
    def rays(self) -> tuple[Any, Any]:
        """X and y (h, w) float64 of the points that the pixels see at unit depth, camera frame."""
        return ray_planes(self.intrinsics)

    def project(self, points: Array) -> Array:
        """Return (3, ...): column, row and depth, m, of the pixel that sees each point (..., 3), m, membrane frame.

        Points at a depth of 0 or less have no pixel; theirs mean nothing.
        """
        seen = np.moveaxis(points - self.place, -1, 0).reshape(3, -1)
        across, along, depth = (self.turn @ seen).reshape(3, *points.shape[:-1])
        depth_safe = np.where(depth > 0, depth, 1.0)
        x, y = across / depth_safe, along / depth_safe
        lens = self.intrinsics
        if any(lens.distortion):
            from stretch_bt.simulation.camera.lens_kernel import bend

            bend(x.reshape(-1), y.reshape(-1), np.array(lens.distortion))
        return np.stack([x * lens.fx + lens.cx, y * lens.fy + lens.cy, depth])
