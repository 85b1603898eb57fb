"""Curvature along the image axes: the BRAND signals as published, and normal curvatures in 1/m."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.robust import sparse
from stretch_bt.perception.smooth import derivative, gain, slope
from stretch_bt.perception.surface import Surface, surface_of
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["Curvatures", "brand", "curvatures", "surface_curvatures"]

Image = npt.NDArray[np.float32]


def brand(points: FloatArray, normals: FloatArray, *, stride: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return the curvature signals (K_i, K_j), (h, w), m, of the paper; positive is convex.

    K_i = <p(i+s, j) - p(i-s, j), n(i+s, j) - n(i-s, j)>, K_j the same along rows (Nascimento et al., BRAND, 2012;
    the paper has s = 1). About (2 s pitch)^2 times the curvature, so compare them at one stride and distance only.
    NaN within `stride` of the edge and where a point or normal is.
    """
    if stride < 1:
        raise InvalidInput(f"a stride is at least 1 pixel, got {stride}")
    if points.shape != normals.shape or points.ndim != 3:
        raise InvalidInput(f"points and normals have one shape (h, w, 3), got {points.shape} and {normals.shape}")
    signals = []
    for axis in (1, 0):
        signal = np.full(points.shape[:2], np.nan, dtype=points.dtype)
        before = np.moveaxis(points, axis, 0), np.moveaxis(normals, axis, 0)
        products = [a[2 * stride :] - a[: -2 * stride] for a in before]
        np.moveaxis(signal, axis, 0)[stride:-stride] = np.einsum("abc,abc->ab", *products)
        signals.append(signal)
    return signals[0], signals[1]


@dataclass(frozen=True, slots=True)
class Curvatures:
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
    surface = surface_of(points, valid, kernel)
    if surface is None:
        none = np.zeros(valid.shape, dtype=np.float32)
        return Curvatures(none, none, none, np.zeros(valid.shape, dtype=bool), 0.0, 0.0, 0.0)
    return surface_curvatures(surface)


def surface_curvatures(surface: Surface) -> Curvatures:
    """Return the curvatures of a surface; with E, F, G, L, M, N of h(x, y) as in any text on differential geometry."""
    h_u, h_uu, h_v, h_vv, h_uv = (
        derivative(surface.height, surface.sigma, *order) for order in ((1, 0), (2, 0), (0, 1), (0, 2), (1, 1))
    )
    h_x, h_y = h_u / surface.x_u, h_v / surface.y_v
    # Perspective makes x_u change where the surface rises; left out, a steep flank gains a false curvature.
    h_xx = (h_uu - h_x * slope(surface.x_u, 1)) / surface.x_u**2
    h_yy = (h_vv - h_y * slope(surface.y_v, 0)) / surface.y_v**2
    h_xy = h_uv / (surface.x_u * surface.y_v)
    one_x, one_y = 1.0 + h_x * h_x, 1.0 + h_y * h_y
    area = one_x + one_y - 1.0
    root = np.sqrt(area)
    i: Image = np.asarray(-h_xx / (one_x * root), dtype=np.float32)
    j: Image = np.asarray(-h_yy / (one_y * root), dtype=np.float32)
    total = -(one_y * h_xx - 2.0 * h_x * h_y * h_xy + one_x * h_yy) / (area * root)
    for image in (i, j, total):
        image[~surface.trusted] = 0.0
    white = surface.noise / surface.pitch**2
    single = white * gain(surface.sigma, (2, 0, 1.0))
    both = white * gain(surface.sigma, (2, 0, 1.0), (0, 2, 1.0))
    trusted = surface.trusted
    return Curvatures(i, j, total, trusted, _sd(i, trusted, single), _sd(j, trusted, single), _sd(total, trusted, both))


def _sd(curvature: Image, trusted: MaskArray, white: float) -> float:
    """Return the noise of a curvature: that of white noise, or the flatter half of the image where it shows more."""
    if not trusted.any():
        return white
    quarter = float(np.quantile(np.abs(sparse(curvature[trusted])), 0.25))
    return max(white, quarter / 0.3186)  # 25 % of a Gaussian lies within 0.3186 sd
