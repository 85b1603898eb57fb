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
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_counts, check_kind, check_numbers, check_unmasked
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.plain_numbers import is_number
from stretch_bt.units import KINDS, Force, Length, Time

__all__ = ["DepthFrame", "Intrinsics", "Pose", "Wrench"]

Array = npt.NDArray[np.float64]

#: counts that 16 bits hold
_MOST_COUNTS = 65_535


def are_finite(given: Any, count: int) -> bool:
    """Return whether something is so many finite numbers."""
    try:
        return len(given) == count and all(math.isfinite(v) for v in given)
    except (TypeError, ValueError, OverflowError):  # of no length, or one of them is no number, or larger than any
        return False


def _as_tuples(made: Any, *names: str) -> None:
    """Turn lists and arrays among the fields of a frozen object into tuples, which can be compared and hashed."""
    for name in names:
        given = getattr(made, name)
        if type(given) is not tuple:
            object.__setattr__(made, name, tuple(map(float, given)))


def _zeros() -> tuple[float, float, float]:
    return (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Pose:
    """Position (3,), m, and rotation vector (3,), rad, of a frame in the world."""

    position: tuple[float, float, float] = field(default_factory=_zeros)
    rotation: tuple[float, float, float] = field(default_factory=_zeros)

    def __post_init__(self) -> None:
        for given in (self.position, self.rotation):
            if not are_finite(given, 3):
                raise InvalidInput(f"a pose needs six finite numbers, got {self.position} and {self.rotation}")
        _as_tuples(self, "position", "rotation")

    @property
    def height(self) -> Length:
        """World z, m."""
        return self.position[2]

    def at_height(self, height: float) -> Pose:
        """Return the same pose with another world z, m."""
        check_numbers("in m", height=height)
        return Pose((self.position[0], self.position[1], height), self.rotation)

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """Return the pose shifted along the world's axes, m."""
        check_numbers("in m", x=x, y=y, z=z)
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

    def __post_init__(self) -> None:
        for given in (self.force, self.torque):
            if not are_finite(given, 3):
                raise InvalidInput(f"a wrench needs three finite numbers of force and of torque, not {given!r}")
        _as_tuples(self, "force", "torque")

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
        check_counts(0, width=self.width, height=self.height)
        if not (are_finite((self.fx, self.fy, self.cx, self.cy), 4) and are_finite(self.distortion, 5)):
            raise InvalidInput(f"intrinsics are finite numbers, got {self}; read them from the camera's calibration")
        # a list, as cameras give it, has no hash, and an array no equality
        object.__setattr__(self, "distortion", tuple(map(float, self.distortion)))
        if not (self.fx > 0 and self.fy > 0):
            raise InvalidInput(
                f"focal lengths are above 0, in pixels, got fx {self.fx:g} and fy {self.fy:g}; a depth camera has about as many"
                " as its image is wide"
            )

    def cropped(self, v0: int, v1: int, u0: int, u1: int) -> Intrinsics:
        """Return the intrinsics of rows v0 to v1 and columns u0 to u1 (ends excluded)."""
        return Intrinsics(self.fx, self.fy, self.cx - u0, self.cy - v0, u1 - u0, v1 - v0, self.distortion)


@dataclass(frozen=True, slots=True, repr=False)
class DepthFrame(BriefRepr):
    """One depth image as the camera sent it, with all that is needed to place it in the world.

    Parameters
    ----------
    raw : (h, w) uint16, in counts of `unit`
        Distance along the optical axis, 0 where invalid; [row, column].
    unit : float, m
        Depth of one count.
    intrinsics : Intrinsics
        Intrinsics of this image, in pixels.
    time : float, s
        Time of the exposure, on the device's own clock.
    sequence : int
        Number of the frame.
    plane_distance : float, m, or None
        Distance from the camera to the flat membrane, along the optical axis: where the membrane frame has its origin.
    hand_height : float, m, or None
        World z of the flat membrane at the exposure; this and the next two are None where the cell does not know them.
    stretch : float, m, or None
        Stretch of the membrane at the exposure.
    pose : Pose or None
        Pose of the hand frame in the world at the exposure.
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
        check_kind("intrinsics", self.intrinsics, Intrinsics)
        expected = (self.intrinsics.height, self.intrinsics.width)
        if not isinstance(self.raw, np.ndarray):
            raise InvalidInput(
                f"a depth image is an array of numpy, not {shown(self.raw)[:80]}; give numpy.asarray(raw)"
            )
        check_unmasked("a depth image is", self.raw, "raw.filled(0)")
        if self.raw.ndim != 2 or self.raw.shape != expected:
            raise InvalidInput(f"a depth image of shape {expected} fits these intrinsics, got {self.raw.shape}")
        if self.raw.dtype != np.uint16:
            raise InvalidInput(f"a depth image holds uint16 counts, got {self.raw.dtype}")
        for name, length in (("unit", self.unit), ("plane_distance", self.plane_distance)):
            if not (length is None and name != "unit") and not (is_number(length) and length > 0):
                raise InvalidInput(f"the {name} of a depth frame is a length above 0 m, got {shown(length)[:80]}")
        for name, number, where in (
            ("time", self.time, "in s"),
            ("hand_height", self.hand_height, "in m"),
            ("stretch", self.stretch, "in m"),
        ):
            if not is_number(number) and not (number is None and name != "time"):
                none = "" if name == "time" else ", or None where it is unknown"
                raise InvalidInput(
                    f"the {name} of a depth frame is a finite number {where}{none}, got {shown(number)[:80]}"
                )
        check_counts(0, sequence=self.sequence)
        if self.pose is not None:
            check_kind("pose", self.pose, Pose)

    @classmethod
    def from_array(
        cls,
        depth: npt.ArrayLike,
        intrinsics: Intrinsics,
        *,
        unit: Length | str,
        plane_distance: Length | None = None,
        stretch: Length | None = None,
        pose: Pose | None = None,
        time: Time = 0.0,
        sequence: int = 0,
    ) -> DepthFrame:
        """Return a frame of a depth image that is made by hand, which every node that takes a frame accepts.

        Parameters
        ----------
        depth : (h, w) float, m, or whole numbers of `unit`
            Distance from the camera along its optical axis; [row, column], rows along the stretch. 0, negative, NaN and infinite are
            invalid. Floats are rounded to whole counts, as a camera does.
        intrinsics : Intrinsics
            Of this image.
        unit : float, m
            Depth of one count, such as 0.000125; 65,535 counts are the farthest.
        plane_distance : float, m, optional
            From the camera to the flat membrane; the median depth along the border of the image unless given.
        stretch : float, m, optional
            Of the membrane.
        pose : Pose, optional
            Of the hand in the world, and with it `hand_height`; unless given, that in which the membrane frame's origin is the world's.
        time : float, s
        sequence : int

        Raises
        ------
        InvalidInput
            The image has another shape or type, holds no valid pixel, or depths that `unit` cannot count.

        Examples
        --------
        >>> camera = Intrinsics(200.0, 200.0, 79.5, 79.5, 160, 160)
        >>> DepthFrame.from_array(np.full((160, 160), 0.1), camera, unit=1e-5).plane_distance
        0.1
        """
        unit = as_length("unit", unit)
        if pose is not None:
            check_kind("pose", pose, Pose)
        raw = _counts(depth, unit)
        place = pose or Pose()
        distance = _border(raw) * unit if plane_distance is None else plane_distance
        return cls(raw, unit, intrinsics, time, sequence, distance, place.height, stretch, place)

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(h, w) float32, m, 0 where invalid."""
        return self.raw * np.float32(self.unit)


def as_numbers(what: str, given: npt.ArrayLike, give: str = "array.filled(numpy.nan)") -> npt.NDArray[Any]:
    """Return an array as it is; raises InvalidInput, which begins with `what`, for rows of different lengths or a mask.

    `give` says what to give in place of an array with a mask.
    """
    check_unmasked(what, given, give)
    try:
        return np.asarray(given)
    except ValueError as error:
        raise InvalidInput(f"{what} an array whose rows have one length: {error}") from None


def as_reals(what: str, given: npt.ArrayLike, unit: str = "") -> npt.NDArray[np.float64]:
    """Return real numbers in double precision; raises InvalidInput, which begins with `what`, for anything else."""
    check_unmasked(what, given, "the values that are known")
    try:
        return np.asarray(given).astype(np.float64, casting="same_kind")
    except (TypeError, ValueError):
        raise InvalidInput(f"{what} real numbers{unit and ', '}{unit}, not {shown(given)[:80]}") from None


def as_length(what: str, given: float | str) -> float:
    """Return a length in m, of a number or of text with a unit; raises InvalidInput."""
    if isinstance(given, str):
        return KINDS["Length"].parse(given)
    if not isinstance(given, int | float | np.number):
        raise InvalidInput(f"{what} is a length in m, or text with a unit, not {shown(given)[:80]}")
    return float(given)


def _counts(depth: npt.ArrayLike, unit: float) -> npt.NDArray[np.uint16]:
    """Return a depth image in counts, 0 where it is invalid."""
    image = as_numbers("a depth image is", depth, "depth.filled(0)")
    if image.ndim != 2 or image.dtype.kind not in "iuf":
        raise InvalidInput(f"a depth image is an array (h, w) of numbers, got {image.dtype} {image.shape}")
    if not (math.isfinite(unit) and unit > 0):
        raise InvalidInput(f"unit is the depth of one count in metres, such as 0.000125, got {unit}")
    counts = np.asarray(
        image if image.dtype.kind in "iu" else np.round(image.astype(np.float64) / unit), dtype=np.float64
    )
    valid = np.isfinite(counts) & (counts > 0)
    if not valid.any():
        raise InvalidInput(
            "no pixel of the depth image is valid; give depths above 0 m as floats, or counts as whole numbers"
        )
    if counts[valid].max() > _MOST_COUNTS:
        raise InvalidInput(
            f"a depth of {counts[valid].max() * unit:.4g} m is more than {_MOST_COUNTS} counts of {unit:g} m; give depths in metres, or"
            " a larger unit"
        )
    return np.where(valid, counts, 0).astype(np.uint16)


def _border(raw: npt.NDArray[np.uint16]) -> float:
    """Return the median count of the valid pixels along the border, or of all where the border has none."""
    border = np.concatenate([raw[0], raw[-1], raw[:, 0], raw[:, -1]])
    known = border[border > 0] if (border > 0).any() else raw[raw > 0]
    return float(np.median(known))
