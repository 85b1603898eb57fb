"""What perception hands to the tree: a contact and a sphere, each number with its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from stretch_bt.brief import BriefRepr
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import Pose
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import Angle, Curvature, Length, Time

__all__ = [
    "CLOUD",
    "CONTACT",
    "DEFORMED",
    "FRAME",
    "INVALID",
    "MADE",
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

#: what makes a contact, a frame and a cloud, for who gave something else
MADE = "`find_contact` and `Contact.from_heights` make one"
FRAME = "a camera and `DepthFrame.from_array` make one"
CLOUD = "`fuse_contact` and `cloud_of` make one"


@dataclass(frozen=True, slots=True)
class SurfaceNoise:
    """Standard deviation, m, of one pixel's height, and the number of pixels that share one error, at least 1."""

    sd: Length
    area: float

    def __post_init__(self) -> None:
        if not (is_number(self.sd) and self.sd >= 0.0 and is_number(self.area) and self.area >= 1.0):
            raise InvalidInput(
                "the noise of a surface has a finite deviation of 0 m or more, and 1 or more pixels that share an error, got"
                f" {shown(self.sd)[:80]} and {shown(self.area)[:80]}"
            )


@dataclass(frozen=True, slots=True, repr=False)
class Contact(BriefRepr):
    """The points of the membrane that touch the object, and the surface around them, as one frame shows them.

    The membrane frame has its origin in the middle of the flat membrane: x along the columns, y along the rows and the stretch, z towards
    the camera. Images are indexed [row, column].

    Parameters
    ----------
    points : (n, 3) float, m, membrane frame
        Points of the pixels in contact, row by row.
    rays : (n, 3) float, unit vectors, membrane frame
        Directions from the camera through each of these points; z is negative.
    labels : (h, w) uint8
        The class of each pixel: 0 undeformed, 1 deformed, 2 in contact, 255 invalid.
    noise : float, m
        Standard deviation of the depth of one pixel, as the frame itself shows it.
    hand_height : float, m, or None
        World z of the flat membrane.
    stretch : float, m, or None
        Stretch of the membrane, by the gripper.
    time : float, s
        Time of the frame, on the device's clock.
    surface : (h, w, 3) float, m, membrane frame
        The point of each pixel, NaN where its label is 255; with the numbers drawn to even out the depth of a camera that counts it coarsely.
    confidence : (h, w) float32
        Probability that each label is right, 0 where it is invalid.
    pose : Pose or None
        Pose of the hand in the world.
    noise_area : float
        How many pixels share one error, 1 where their noise is independent.
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

    @classmethod
    def from_heights(
        cls,
        heights: npt.ArrayLike,
        pixel: Length | str,
        *,
        noise: Length | str,
        labels: npt.ArrayLike | None = None,
        stretch: Length | None = None,
        pose: Pose | None = None,
        time: Time = 0.0,
    ) -> Contact:
        """Return a contact of heights that are made by hand, which every node that takes a contact accepts.

        Parameters
        ----------
        heights : (h, w) float, m
            Heights of the membrane above its undeformed plane, towards the camera; [row, column], rows along the stretch. NaN where nothing
            is seen. They are taken as they are: add noise of your own where a test asks for some.
        pixel : float, m
            Distance of neighbouring pixels, along rows and columns. The middle of the image is the middle of the membrane.
        noise : float, m
            Standard deviation of one height, above 0.
        labels : (h, w) uint8 or bool, optional
            Classes as in a contact, or where the membrane touches; as `segment` finds them unless given.
        stretch : float, m, optional
            Stretch of the membrane.
        pose : Pose, optional
            Pose of the hand in the world; unless given, the membrane frame's origin is the world's.
        time : float, s

        The camera looks straight down from far away, so that all rays are (0, 0, -1).

        Raises
        ------
        NoContact
            No pixel is in contact.
        InvalidInput
            An array has another shape or type, or a length is in another unit than metres.

        Examples
        --------
        >>> import numpy as np
        >>> y, x = np.mgrid[-80:81, -80:81] * 0.5e-3
        >>> Contact.from_heights(np.maximum(8e-3 - (x**2 + y**2) / 60e-3, 0), 0.5e-3, noise=0.1e-3).labels.shape
        (161, 161)
        """
        from stretch_bt.perception.by_hand import contact_from_heights

        return contact_from_heights(heights, pixel, noise=noise, labels=labels, stretch=stretch, pose=pose, time=time)

    @property
    def surface_noise(self) -> SurfaceNoise:
        """The noise as the fits of shapes take it."""
        return SurfaceNoise(self.noise, self.noise_area)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A fitted sphere.

    Parameters
    ----------
    radius, radius_sd : float, m
        Positive, and its standard deviation.
    center, center_sd : (3,) float, m
        In the frame of the points that were fitted: a contact's points lie in the membrane frame, so that z is negative below the plane of
        the undeformed membrane, on the far side of the camera.
    curvature, curvature_sd : float, 1/m
        One over the radius, positive where the sphere is convex to the camera.
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
    """A fitted cone; `angle`, rad, is the angle between its surface and the plane across its axis, positive where convex.

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

    The evidence is None where the shape could not be fitted at all.
    """

    kind: ShapeKind
    evidence: float | None
    refused: str = ""


@dataclass(frozen=True, slots=True)
class Shape:
    """The simplest shape that explains points as well as any; `ranking` has all that were compared, best first.

    `residual_sd`, m, is how far a point lies off it. `radius` is a sphere's or a cylinder's, `angle`, rad, a
    cone's; None for shapes that have none.
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
