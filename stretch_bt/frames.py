"""Coordinate frames, camera intrinsics and depth frames.

| frame | origin | axes |
|---|---|---|
| world | on the table | z up |
| hand | the centre of the flat membrane | z away from the object, as the world's z when the hand points down |
| membrane | the centre of the flat membrane | x along i (image columns), y along j (image rows, the stretch direction), z towards the camera |
| camera | the optical centre | x along columns, y along rows, z forward, as every camera library has it |

With x along columns and y along rows, z towards the camera makes the membrane frame left-handed; the hand frame is its
right-handed twin with y reversed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.units import Force, Length, Time

__all__ = ["DepthFrame", "Intrinsics", "Pose", "Wrench"]

Array = npt.NDArray[np.float64]


def _zeros() -> tuple[float, float, float]:
    return (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Pose:
    """Position (3,), m, and rotation vector (3,), rad, of a frame in the world."""

    position: tuple[float, float, float] = field(default_factory=_zeros)
    rotation: tuple[float, float, float] = field(default_factory=_zeros)

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in (*self.position, *self.rotation)):
            raise InvalidInput(f"a pose needs six finite numbers, got {self.position} and {self.rotation}")

    @property
    def height(self) -> Length:
        """World z, m."""
        return self.position[2]

    def at_height(self, height: float) -> Pose:
        """Return the same pose with another world z, m."""
        return Pose((self.position[0], self.position[1], height), self.rotation)

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """Return the pose shifted along the world's axes, m."""
        p = self.position
        return Pose((p[0] + x, p[1] + y, p[2] + z), self.rotation)

    def matrix(self) -> Array:
        """Return the (3, 3) rotation matrix by Rodrigues' formula."""
        vector = np.asarray(self.rotation)
        angle = float(np.linalg.norm(vector))
        if angle < 1e-12:
            return np.eye(3)
        x, y, z = vector / angle
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turned: Array = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
        return turned


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force (3,), N, and torque (3,), N m, that the world exerts on the hand, in world axes."""

    force: tuple[float, float, float]
    torque: tuple[float, float, float] = field(default_factory=_zeros)

    @property
    def magnitude(self) -> Force:
        """Norm of the force, N."""
        return math.hypot(*self.force)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Pinhole intrinsics in pixels, of an image `height` rows by `width` columns.

    `distortion` holds five inverse Brown-Conrady coefficients (k1, k2, p1, p2, k3), as RealSense depth cameras report
    them: they map distorted normalised coordinates to undistorted ones.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in (self.fx, self.fy, self.cx, self.cy, *self.distortion)):
            raise InvalidInput(f"intrinsics are finite numbers, got {self}; read them from the camera's calibration")
        if not (self.fx > 0 and self.fy > 0):
            raise InvalidInput(
                f"focal lengths are above 0, in pixels, got fx {self.fx:g} and fy {self.fy:g}; a depth camera has about as many"
                " as its image is wide"
            )

    def cropped(self, v0: int, v1: int, u0: int, u1: int) -> Intrinsics:
        """Return the intrinsics of rows v0 to v1 and columns u0 to u1 (ends excluded)."""
        return Intrinsics(self.fx, self.fy, self.cx - u0, self.cy - v0, u1 - u0, v1 - v0, self.distortion)


@dataclass(frozen=True, slots=True)
class DepthFrame:
    """One depth image as the camera sent it, with what is needed to place it in the world.

    `raw` is (h, w) uint16 in counts of `unit` metres, 0 where invalid. `time` is the device's own, s. `plane_distance`
    is the distance from the camera to the flat membrane along the optical axis, m. `hand_height` (world z of the flat
    membrane, m), `stretch` (m) and `pose` (of the hand frame in the world) are those at the moment of exposure, None
    where the cell does not know them.
    """

    raw: npt.NDArray[np.uint16]
    unit: float
    intrinsics: Intrinsics
    time: Time
    sequence: int
    plane_distance: Length | None = None
    hand_height: Length | None = None
    stretch: Length | None = None
    pose: Pose | None = None

    def __post_init__(self) -> None:
        expected = (self.intrinsics.height, self.intrinsics.width)
        if self.raw.ndim != 2 or self.raw.shape != expected:
            raise InvalidInput(f"a depth image of shape {expected} fits these intrinsics, got {self.raw.shape}")
        if self.raw.dtype != np.uint16:
            raise InvalidInput(f"a depth image holds uint16 counts, got {self.raw.dtype}")
        for name, length in (("unit", self.unit), ("plane_distance", self.plane_distance)):
            if length is not None and not (math.isfinite(length) and length > 0):
                raise InvalidInput(f"the {name} of a depth frame is a length above 0 m, got {length}")

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(h, w) float32, m, 0 where invalid."""
        return self.raw * np.float32(self.unit)
