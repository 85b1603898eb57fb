"""Curvature along the image axes: the BRAND signals as published, and normal curvatures in 1/m."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_counts
from stretch_bt.brief import BriefRepr
from stretch_bt.errors import InvalidInput
from stretch_bt.perception.lateral import Lateral, lateral
from stretch_bt.perception.robust import quantile, sample
from stretch_bt.perception.smooth import derivative, enlarge, ready_for_differences
from stretch_bt.perception.surface import Surface, binned_surface, check_array, check_points, clean
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["Curvatures", "SurfaceDerivatives", "along_axes", "bending", "brand", "curvatures", "spread"]

Image = npt.NDArray[np.float32]


def brand(points: FloatArray, normals: FloatArray, *, stride: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return the curvature signals (K_i, K_j), (h, w), m, of the paper; positive is convex.

    K_i = <p(i+s, j) - p(i-s, j), n(i+s, j) - n(i-s, j)>, K_j the same along rows (Nascimento et al., BRAND, 2012;
    the paper has s = 1). About (2 s pitch)^2 times the curvature, so compare them at one stride and distance only.
    NaN within `stride` of the edge and where a point or normal is.
    """
    check_counts(1, stride=stride)
    check_points(points)
    check_array("normals", normals)
    if points.shape != normals.shape or normals.dtype.kind != "f":
        raise InvalidInput(f"points and normals have one shape (h, w, 3), got {points.shape} and {normals.shape}")
    signals = []
    for axis in (1, 0):
        signal = np.full(points.shape[:2], np.nan, dtype=points.dtype)
        before = np.moveaxis(points, axis, 0), np.moveaxis(normals, axis, 0)
        products = [a[2 * stride :] - a[: -2 * stride] for a in before]
        np.moveaxis(signal, axis, 0)[stride:-stride] = np.einsum("abc,abc->ab", *products)
        signals.append(signal)
    return signals[0], signals[1]


@dataclass(frozen=True, slots=True, repr=False)
class Curvatures(BriefRepr):
    """Normal curvatures along i and j and twice the mean curvature, (h, w), 1/m, positive where convex to the camera.

    0 where `trusted` is False: a pixel there shows no curvature. `i_sd`, `j_sd` and `sum_sd` are the noise of one
    value, 1/m, as the image itself shows it.
    """

    i: Image
    j: Image
    sum: Image
    trusted: MaskArray
    i_sd: float
    j_sd: float
    sum_sd: float


def curvatures(points: FloatArray, valid: MaskArray, *, kernel: float = 1.9e-3) -> Curvatures:
    """Return the curvatures of organised points (h, w, 3), m, by Gaussian second derivatives of `kernel`, m."""
    check_points(points, valid)
    i, j, total = (np.zeros(valid.shape, dtype=np.float32) for _ in range(3))
    trusted = np.zeros(valid.shape, dtype=bool)
    cleaned = clean(points, valid)
    if cleaned is None:
        return Curvatures(i, j, total, trusted, 0.0, 0.0, 0.0)
    surface = binned_surface(cleaned, kernel)
    moves = lateral(cleaned, kernel)
    bent = bending(surface, moves)
    binned = (*along_axes(surface, bent), _twice_mean(surface, bent, moves))
    shape = cleaned.valid.shape
    near = enlarge(surface.trusted.astype(np.float32), surface.step, shape) > 0.5
    trusted[cleaned.box] = near
    for image, coarse in zip((i, j, total), binned, strict=True):
        image[cleaned.box] = np.where(near, enlarge(coarse, surface.step, shape), 0.0)
    noise = [
        surface.noise_after(*o) / surface.pitch**2 for o in ([(2, 0, 1.0)], [(0, 2, 1.0)], [(2, 0, 1.0), (0, 2, 1.0)])
    ]
    sd = (spread(image, surface.trusted, expected) for image, expected in zip(binned, noise, strict=True))
    return Curvatures(i, j, total, trusted, *sd)


@dataclass(frozen=True, slots=True)
class SurfaceDerivatives:
    """Slopes `x`, `y` and second derivatives `xx`, `yy`, 1/m, of the height of a surface in its bins."""

    x: Image
    y: Image
    xx: Image
    yy: Image

    @property
    def root(self) -> Image:
        """sqrt(1 + x^2 + y^2)."""
        return np.sqrt(1.0 + self.x * self.x + self.y * self.y)


def bending(surface: Surface, lateral: Lateral) -> SurfaceDerivatives:
    """Return the derivatives of a surface, or of part of it."""
    from stretch_bt.perception.surface_kernel import fill_bending

    smooth, (moves, v, u) = ready_for_differences(surface.height, surface.sigma), lateral.of(surface)
    found = np.empty((4, *surface.height.shape), dtype=np.float32)
    share = lateral.every // surface.step
    fill_bending(smooth, moves.reshape(len(moves), -1), v, u, 1.0 / share, *found)
    return SurfaceDerivatives(*found)


def along_axes(surface: Surface, bent: SurfaceDerivatives) -> tuple[Image, Image]:
    """Return the normal curvatures along i and j, 1/m, positive where convex, 0 where not trusted."""
    from stretch_bt.perception.surface_kernel import fill_along

    i, j = np.empty_like(bent.x), np.empty_like(bent.x)
    fill_along(bent.x, bent.y, bent.xx, bent.yy, surface.trusted, i, j)
    return i, j


def _twice_mean(surface: Surface, bent: SurfaceDerivatives, lateral: Lateral) -> Image:
    """Return twice the mean curvature, 1/m, 0 where not trusted (any text on differential geometry, for h(x, y))."""
    (h, w), (moves, v, u) = bent.x.shape, lateral.of(surface)
    area = np.prod(moves[v : v + h, u : u + w, :2], axis=-1) * np.float32((surface.step / lateral.every) ** 2)
    h_xy = derivative(surface.height, surface.sigma, 1, 1) / area
    one_x, one_y = 1.0 + bent.x * bent.x, 1.0 + bent.y * bent.y
    total = -(one_y * bent.xx - 2.0 * bent.x * bent.y * h_xy + one_x * bent.yy) / bent.root**3
    return np.where(surface.trusted, total, np.float32(0))


def spread(curvature: Image, trusted: MaskArray, expected: float) -> float:
    """Return the noise of a curvature: as expected, or as the flatter half of the image shows it where that is more."""
    values = sample(curvature, trusted)
    if not values.size:
        return expected
    quarter = quantile(np.abs(values), 0.25)
    return max(expected, quarter / 0.3186)  # 25 % of a Gaussian lies within 0.3186 sd
