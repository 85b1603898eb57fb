"""From a depth image to points: a ray table per camera, and the way into the membrane frame."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind, check_numbers
from stretch_bt.errors import InvalidInput, shown
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, are_finite, as_numbers
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.surface import check_array
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["deproject", "depth_of", "points_of", "to_membrane", "to_world", "view_rays", "world_turn"]

WIDEST = 100.0  # m aside for each metre ahead; no camera sees farther than 89 degrees from its axis
PLAUSIBLE = (1e-3, 20.0)  # metres; a median depth outside it is in another unit


def deproject(depth: FloatArray | DepthFrame, intrinsics: Intrinsics | None = None) -> tuple[FloatArray, MaskArray]:
    """Turn a depth image into points in the camera frame: x along columns, y along rows, z forward.

    Parameters
    ----------
    depth : (h, w) float, m, or a DepthFrame
        Distance along the optical axis; 0, negative, NaN and infinite are invalid.
    intrinsics : Intrinsics
        Intrinsics of this image; may be left out for a DepthFrame, which carries its own.

    Returns
    -------
    points : (h, w, 3) float of the depth's precision, m, NaN where invalid
    valid : (h, w) bool

    Raises
    ------
    InvalidInput
        The image does not fit the intrinsics, is not in floating-point metres, or its depths are in another unit.
    """
    return points_of(depth, intrinsics, 1.0, 0.0)


def points_of(
    depth: FloatArray | DepthFrame, intrinsics: Intrinsics | None, sign: float, offset: float
) -> tuple[FloatArray, MaskArray]:
    """Do as `deproject`, with z = sign * depth + offset."""
    from stretch_bt.perception.surface_kernel import fill_points

    if isinstance(depth, DepthFrame):
        intrinsics = depth.intrinsics if intrinsics is None else intrinsics
    image, valid = depth_of(depth)
    if intrinsics is None:
        raise InvalidInput("deproject needs the intrinsics of the image")
    check_kind("intrinsics", intrinsics, Intrinsics)
    if image.shape != (intrinsics.height, intrinsics.width):
        raise InvalidInput(
            f"these intrinsics are of {intrinsics.height} rows by {intrinsics.width} columns, the image is {image.shape}"
        )
    points = np.empty((*image.shape, 3), dtype=image.dtype)
    rows = points.reshape(image.shape[0], 3 * image.shape[1])
    fill_points(
        np.require(image, requirements=["C", "W"]),
        valid,
        *ray_planes(intrinsics, image.dtype.char),
        sign,
        offset,
        np.nan,
        rows,
    )
    return points, valid


def depth_of(depth: FloatArray | DepthFrame) -> tuple[FloatArray, MaskArray]:
    """Return the depth image (h, w), m, of an array or frame, and where it is valid; raises InvalidInput."""
    image: npt.NDArray[Any] = (
        depth.depth if isinstance(depth, DepthFrame) else as_numbers("a depth image is", depth, "depth.filled(0)")
    )
    if image.ndim != 2:
        raise InvalidInput(f"a depth image has shape (h, w), got {image.shape}")
    if image.dtype.kind != "f":
        raise InvalidInput(
            f"a depth image holds floating-point metres, got {image.dtype}; multiply counts by their unit"
        )
    # The kernels take these two: other precisions and byte orders become the nearest of them.
    image = image.astype(np.float32 if image.dtype.itemsize <= 4 else np.float64, copy=False)
    valid: MaskArray = np.ascontiguousarray((image > 0) & (image < np.inf))
    some = sample(image, valid)
    if some.size and not PLAUSIBLE[0] <= quantile(some) <= PLAUSIBLE[1]:
        raise InvalidInput(f"a depth image is in metres; a median of {quantile(some):.3g} m is another unit")
    return image, valid


@lru_cache(maxsize=16)
def ray_planes(intrinsics: Intrinsics, dtype: str = "d") -> tuple[FloatArray, FloatArray]:
    """Return x and y (h, w) of the ray table, each in one piece of memory."""
    table = ray_table(intrinsics, dtype)
    return np.array(table[..., 0], order="C"), np.array(table[..., 1], order="C")


def _too_wide(intrinsics: Intrinsics) -> InvalidInput:
    return InvalidInput(
        f"by {intrinsics} a pixel looks more than {WIDEST:g} m aside for each metre ahead: compare focal lengths, in pixels, and"
        " distortion with the camera's calibration"
    )


@lru_cache(maxsize=16)
def ray_table(intrinsics: Intrinsics, dtype: str = "d") -> FloatArray:
    """Return (h, w, 3): the point on each pixel's ray at unit depth.

    Inverse Brown-Conrady takes distorted to undistorted coordinates, so no iteration is needed
    (librealsense, rs2_deproject_pixel_to_point, RS2_DISTORTION_INVERSE_BROWN_CONRADY).
    """
    k1, k2, p1, p2, k3 = intrinsics.distortion
    x = (np.arange(intrinsics.width) - intrinsics.cx)[None, :] / intrinsics.fx
    y = (np.arange(intrinsics.height) - intrinsics.cy)[:, None] / intrinsics.fy
    if not max(np.abs(x).max(initial=0.0), np.abs(y).max(initial=0.0)) <= WIDEST:
        raise _too_wide(intrinsics)
    r2 = x * x + y * y
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        across = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        down = y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y)
    if not max(np.abs(across).max(initial=0.0), np.abs(down).max(initial=0.0)) <= WIDEST:
        raise _too_wide(intrinsics)
    table = np.stack([across, down, np.ones_like(across)], axis=2).astype(dtype)
    table.flags.writeable = False
    return table


def to_membrane(points: FloatArray, plane_distance: float) -> FloatArray:
    """Move points (..., 3), m, from the camera frame to the membrane frame: z = plane_distance - depth."""
    _check_triples(points)
    check_numbers("in m", plane_distance=plane_distance)
    moved: FloatArray = np.array(points, copy=True)
    moved[..., 2] = plane_distance - moved[..., 2]
    return moved


def world_turn(pose: Pose) -> npt.NDArray[np.float64]:
    """Return (3, 3), which takes directions of the membrane frame of a hand into the world.

    The membrane frame is left-handed; with its y reversed it is the hand frame.
    """
    turn: npt.NDArray[np.float64] = pose.matrix() * [1.0, -1.0, 1.0]
    return turn


def to_world(points: FloatArray, pose: Pose) -> npt.NDArray[np.float64]:
    """Move points (n, 3), m, from the membrane frame of a hand into the world."""
    moved: npt.NDArray[np.float64] = points @ world_turn(pose).T + pose.position
    return moved


def _check_triples(points: FloatArray) -> None:
    """Raise InvalidInput unless points are (..., 3) floats."""
    check_array("points", points)
    if points.ndim < 1 or points.shape[-1] != 3 or points.dtype.kind != "f":
        raise InvalidInput(f"points are (..., 3) floats in m, got {points.dtype} {points.shape}")


def view_rays(points: FloatArray, camera: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return unit vectors (..., 3) from the camera through points (..., 3), both in one frame, m.

    In the membrane frame the camera is at (0, 0, plane_distance).

    Raises
    ------
    InvalidInput
        The points have another shape, the camera is no place, or a point is at the camera.
    """
    _check_triples(points)
    if not are_finite(camera, 3):
        raise InvalidInput(
            f"camera is the place (x, y, z) of the camera, three finite numbers in m, got {shown(camera)[:80]}"
        )
    away = points - np.asarray(camera, dtype=points.dtype)
    far = np.sqrt(np.square(away) @ np.ones(3, away.dtype))
    if not far.all():
        raise InvalidInput(
            f"{np.count_nonzero(far == 0.0)} points are at the camera, so that no ray goes through them; set points without depth to NaN, or"
            " leave them out"
        )
    rays: FloatArray = away / far[..., None]
    return rays
