"""Analytic surfaces of a tense membrane over an object, as a pinhole depth camera sees them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics

__all__ = [
    "PLANE_DISTANCE",
    "camera",
    "cap",
    "cone_press",
    "curvature_bound",
    "disc_press",
    "distance_from_axis",
    "noisy",
    "render",
    "sphere_press",
]

Array = npt.NDArray[np.float64]
Profile = Callable[[Any], Any]

PLANE_DISTANCE = 0.2
OUTER = 47e-3
STEPS, CLOSE = 60, 1e-13  # CLOSE: m


def camera(height: int = 213, width: int = 333, focal: float = 476.0) -> Intrinsics:
    """Return the intrinsics of a camera whose axis meets the middle of its image."""
    return Intrinsics(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)


def sphere_press(radius: float, angle: float) -> Profile:
    """Return height over distance from the axis: a cap up to `angle`, rad, then a logarithmic skirt of equal slope."""
    edge = radius * np.sin(angle)
    drop = edge * edge / (radius * np.cos(angle))
    at_edge = drop * np.log(OUTER / edge)
    top = at_edge - radius * np.cos(angle)

    def height(r: Any) -> Any:
        skirt = np.maximum(at_edge - drop * np.log(np.maximum(r, 1e-9) / edge), 0.0)
        return np.where(r < edge, top + np.sqrt(np.maximum(radius**2 - r * r, 0.0)), skirt)

    return height


def disc_press(radius: float, depth: float) -> Profile:
    """Return height over distance from the axis: a flat disc at `depth`, m, then a logarithmic skirt."""
    drop = depth / np.log(OUTER / radius)
    return lambda r: np.where(r < radius, depth, np.maximum(depth - drop * np.log(np.maximum(r, 1e-9) / radius), 0.0))


def cone_press(slope: float, edge: float) -> Profile:
    """Return height over distance from the axis: a cone up to `edge`, m, then a logarithmic skirt of equal slope."""
    drop = slope * edge
    top = drop * (1.0 + np.log(OUTER / edge))
    return lambda r: np.where(r < edge, top - slope * r, np.maximum(drop * np.log(OUTER / np.maximum(r, 1e-9)), 0.0))


def render(profile: Profile, intrinsics: Intrinsics, x0: float = 0.0, y0: float = 0.0) -> Array:
    """Return the depth image (h, w), m, of a profile about the axis (x0, y0): where each ray meets it, by the Illinois method."""
    x = ((np.arange(intrinsics.width) - intrinsics.cx) / intrinsics.fx)[None, :]
    y = ((np.arange(intrinsics.height) - intrinsics.cy) / intrinsics.fy)[:, None]

    def behind(depth: Array) -> Array:
        return np.asarray(depth - PLANE_DISTANCE + profile(np.hypot(depth * x - x0, depth * y - y0)))

    near = np.full((intrinsics.height, intrinsics.width), 0.5 * PLANE_DISTANCE)
    far = np.full_like(near, PLANE_DISTANCE + 1e-6)
    by_near, by_far, depth, last = behind(near), behind(far), far, np.zeros(near.shape)
    for _ in range(STEPS):
        depth = (near * by_far - far * by_near) / (by_far - by_near)
        left = behind(depth)
        if np.abs(left).max() < CLOSE:
            break
        # an end that stays for two steps counts by half, so that it moves as well
        short = left < 0.0
        by_far = np.where(short, by_far * np.where(last < 0.0, 0.5, 1.0), left)
        by_near = np.where(short, left, by_near * np.where(last > 0.0, 0.5, 1.0))
        near, far = np.where(short, depth, near), np.where(short, far, depth)
        last = np.where(short, -1.0, 1.0)
    else:
        raise ArithmeticError(f"no depth within {STEPS} steps: the profile has a jump, or no height somewhere")
    return depth


def distance_from_axis(depth: Array, intrinsics: Intrinsics) -> Array:
    """Return how far, m, the point seen by each pixel is from the optical axis."""
    u = np.arange(intrinsics.width) - intrinsics.cx
    v = np.arange(intrinsics.height) - intrinsics.cy
    return np.asarray(depth * np.hypot(u[None, :] / intrinsics.fx, v[:, None] / intrinsics.fy))


def noisy(depth: Array, sd: float, rng: np.random.Generator, *, quantum: float = 0.125e-3) -> npt.NDArray[np.float32]:
    """Add white noise, quantise, and drop one pixel in a hundred."""
    seen = np.round((depth + rng.normal(0.0, sd, depth.shape)) / quantum) * quantum
    seen[rng.random(depth.shape) < 0.01] = 0.0
    return seen.astype(np.float32)


def cap(radius: float, angle: float, pitch: float = 0.42e-3) -> Array:
    """Return points (n, 3), m, of a spherical cap on a pixel grid that is not centred on it."""
    edge = radius * np.sin(angle)
    grid = np.arange(-np.ceil(edge / pitch) - 1, np.ceil(edge / pitch) + 2) * pitch
    x, y = np.meshgrid(grid + 0.13 * pitch, grid + 0.31 * pitch)
    inside = x * x + y * y <= edge * edge
    x, y = x[inside], y[inside]
    return np.column_stack([x, y, np.sqrt(radius**2 - x * x - y * y)])


def curvature_bound(points: Array, radius: float, noise: float) -> float:
    """Return the Cramer-Rao bound of 1/R, 1/m, for white noise along z on points of a sphere about the origin."""
    x, y, z = points.T
    jacobian = np.column_stack([x / z, y / z, np.ones_like(x), radius / z])
    covariance = np.linalg.inv(jacobian.T @ jacobian) * noise**2
    return float(np.sqrt(covariance[3, 3])) / radius**2
