"""What perception hands to the tree: a contact and a sphere, each number with its standard deviation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.units import Angle, Curvature, Length, Time

__all__ = [
    "CONTACT",
    "DEFORMED",
    "INVALID",
    "UNDEFORMED",
    "Candidate",
    "Cone",
    "Contact",
    "Cylinder",
    "FloatArray",
    "LabelArray",
    "MaskArray",
    "Plane",
    "Shape",
    "ShapeKind",
    "Sphere",
    "SurfaceNoise",
]

FloatArray = npt.NDArray[np.floating[Any]]
MaskArray = npt.NDArray[np.bool_]
LabelArray = npt.NDArray[np.uint8]

ShapeKind = Literal["plane", "sphere", "cylinder", "cone"]

UNDEFORMED, DEFORMED, CONTACT, INVALID = 0, 1, 2, 255


@dataclass(frozen=True, slots=True)
class SurfaceNoise:
    """Standard deviation, m, of one pixel's height, and the number of pixels that share one error, at least 1."""

    sd: Length
    area: float

    def of_means(self, pixels: float) -> SurfaceNoise:
        """Return the noise of means over squares of so many pixels, and how many of them share one error.

        Noise that a Gaussian made alike is meant; the squares blur as a Gaussian of their own variance does.
        """
        pixels = max(pixels, 1.0)
        area = 1.0 + (self.area - 1.0) / pixels
        return SurfaceNoise(self.sd * math.sqrt(self.area / (area * pixels)), area)


@dataclass(frozen=True, slots=True)
class Contact:
    """The points of the membrane that touch the object, in one frame.

    `points` (n, 3), m, and unit `rays` (n, 3), from the camera through each point, are in the membrane frame. `labels`
    (h, w) uint8 holds the class of every pixel, `confidence` (h, w) float32 the probability that it is right, 0 where
    invalid, and `surface` (h, w, 3), m, membrane frame, its point, NaN where the label is 255. `noise` is the depth
    standard deviation of one pixel, m, as the frame itself shows it, and `noise_area` how many pixels share one error,
    1 where their noise is independent. `hand_height`, `stretch`, m, `time`, s, and
    `pose`, of the hand in the world, are those of the frame.
    """

    points: FloatArray
    rays: FloatArray
    labels: LabelArray
    noise: Length
    hand_height: Length | None
    stretch: Length | None
    time: Time
    surface: FloatArray
    confidence: FloatArray
    pose: Pose | None = None
    noise_area: float = 1.0

    @property
    def surface_noise(self) -> SurfaceNoise:
        """The noise as the fits of shapes take it."""
        return SurfaceNoise(self.noise, self.noise_area)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A fitted sphere; `radius` is positive, the sign of `curvature` is positive where it is convex to the camera.

    `center` and `center_sd` are (3,), m, in the frame of the points that were fitted.
    """

    radius: Length
    radius_sd: Length
    center: FloatArray
    center_sd: FloatArray
    curvature: Curvature
    curvature_sd: Curvature


@dataclass(frozen=True, slots=True)
class Plane:
    """A fitted plane: unit `normal` (3,) towards the camera and `offset`, m, its distance from the origin along it.

    Both, and their standard deviations, are in the frame of the points that were fitted.
    """

    normal: FloatArray
    normal_sd: FloatArray
    offset: Length
    offset_sd: Length


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A fitted cylinder; `radius` is positive, the sign of `curvature` is positive where it is convex to the camera.

    `axis` (3,) is the unit direction of its axis, either way, and `point` (3,), m, the point of the axis nearest to the
    middle of the points, both in the frame of the points that were fitted.
    """

    radius: Length
    radius_sd: Length
    axis: FloatArray
    axis_sd: FloatArray
    point: FloatArray
    point_sd: FloatArray
    curvature: Curvature
    curvature_sd: Curvature


@dataclass(frozen=True, slots=True)
class Cone:
    """A fitted cone; `angle`, rad, is that between its surface and the plane across its axis, positive where convex.

    `apex` (3,), m, and `axis` (3,), the unit direction of its axis towards the camera, are in the frame of the points
    that were fitted.
    """

    angle: Angle
    angle_sd: Angle
    apex: FloatArray
    apex_sd: FloatArray
    axis: FloatArray
    axis_sd: FloatArray


@dataclass(frozen=True, slots=True)
class Candidate:
    """One shape among those compared: its evidence in nats against the best one's, at most 0, and why it is refused.

    The evidence is minus infinity where the shape could not be fitted at all.
    """

    kind: ShapeKind
    evidence: float
    refused: str = ""


@dataclass(frozen=True, slots=True)
class Shape:
    """The simplest shape that explains points as well as any; `ranking` has all that were compared, best first.

    `residual_sd`, m, is how far a point lies off it. `radius` is that of a sphere or cylinder, `angle`, rad, that of a
    cone; None for shapes that have none.
    """

    kind: ShapeKind
    fit: Plane | Sphere | Cylinder | Cone
    residual_sd: Length
    ranking: tuple[Candidate, ...]

    @property
    def radius(self) -> Length | None:
        """Radius, m, of a sphere or cylinder."""
        return self.fit.radius if isinstance(self.fit, Sphere | Cylinder) else None

    @property
    def radius_sd(self) -> Length | None:
        """Standard deviation of the radius, m."""
        return self.fit.radius_sd if isinstance(self.fit, Sphere | Cylinder) else None

    @property
    def angle(self) -> Angle | None:
        """Angle, rad, between the surface of a cone and the plane across its axis."""
        return self.fit.angle if isinstance(self.fit, Cone) else None

    @property
    def angle_sd(self) -> Angle | None:
        """Standard deviation of the angle, rad."""
        return self.fit.angle_sd if isinstance(self.fit, Cone) else None
