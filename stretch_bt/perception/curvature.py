"""Curvature along the image axes: the BRAND signals as published, and normal curvatures in 1/m."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.perception.robust import sample
from stretch_bt.perception.smooth import derivative, enlarge, gain, slope
from stretch_bt.perception.surface import Surface, binned_surface, clean
from stretch_bt.perception.types import FloatArray, MaskArray

__all__ = ["Bending", "Curvatures", "bending", "brand", "curvatures", "spread"]

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
    i, j, total = (np.zeros(valid.shape, dtype=np.float32) for _ in range(3))
    trusted = np.zeros(valid.shape, dtype=bool)
    cleaned = clean(points, valid)
    if cleaned is None:
        return Curvatures(i, j, total, trusted, 0.0, 0.0, 0.0)
    surface = binned_surface(cleaned, kernel)
    bent = bending(surface)
    binned = (bent.i, bent.j, _twice_mean(surface, bent))
    shape = cleaned.valid.shape
    near = enlarge(surface.trusted.astype(np.float32), surface.step, shape) > 0.5
    trusted[cleaned.box] = near
    for image, coarse in zip((i, j, total), binned, strict=True):
        image[cleaned.box] = np.where(near, enlarge(coarse, surface.step, shape), 0.0)
    white = bent.white * gain(surface.sigma, (2, 0, 1.0), (0, 2, 1.0))
    return Curvatures(i, j, total, trusted, bent.i_sd, bent.j_sd, spread(binned[2], surface.trusted, white))


@dataclass(frozen=True, slots=True)
class Bending:
    """Second derivatives of a surface in its bins, 1/m, and the normal curvatures along i and j, positive if convex.

    `x` and `y` are the slopes, `xx` and `yy` the second derivatives of the height; `i` and `j` are 0 where not trusted.
    `white` is the noise of one bin over its size squared, 1/m: times the gain of a filter it is that filter's noise.
    """

    x: Image
    y: Image
    xx: Image
    yy: Image
    root: Image
    i: Image
    j: Image
    i_sd: float
    j_sd: float
    white: float


def bending(surface: Surface) -> Bending:
    """Return the second derivatives of a surface and its normal curvatures."""
    h_u, h_uu, h_v, h_vv = (derivative(surface.height, surface.sigma, *o) for o in ((1, 0), (2, 0), (0, 1), (0, 2)))
    h_x, h_y = h_u / surface.x_u, h_v / surface.y_v
    # Perspective makes x_u change where the surface rises; left out, a steep flank gains a false curvature.
    h_xx = (h_uu - h_x * slope(surface.x_u, 1)) / (surface.x_u * surface.x_u)
    h_yy = (h_vv - h_y * slope(surface.y_v, 0)) / (surface.y_v * surface.y_v)
    one_x, one_y = 1.0 + h_x * h_x, 1.0 + h_y * h_y
    root = np.sqrt(one_x + one_y - 1.0)
    i, j = h_xx / (one_x * root), h_yy / (one_y * root)
    for image in (i, j):
        np.negative(image, out=image)
        image[~surface.trusted] = 0.0
    white = surface.bin_noise / surface.pitch**2
    single = white * gain(surface.sigma, (2, 0, 1.0))
    sd = (spread(k, surface.trusted, single) for k in (i, j))
    return Bending(h_x, h_y, h_xx, h_yy, root, i, j, *sd, white)


def _twice_mean(surface: Surface, bent: Bending) -> Image:
    """Return twice the mean curvature, 1/m, 0 where not trusted (any text on differential geometry, for h(x, y))."""
    h_xy = derivative(surface.height, surface.sigma, 1, 1) / (surface.x_u * surface.y_v)
    one_x, one_y = 1.0 + bent.x * bent.x, 1.0 + bent.y * bent.y
    total = -(one_y * bent.xx - 2.0 * bent.x * bent.y * h_xy + one_x * bent.yy) / bent.root**3
    return np.where(surface.trusted, total, np.float32(0))


def spread(curvature: Image, trusted: MaskArray, white: float) -> float:
    """Return the noise of a curvature: that of white noise, or the flatter half of the image where it shows more."""
    values = sample(curvature, trusted)
    if not values.size:
        return white
    quarter = float(np.quantile(np.abs(values), 0.25))
    return max(white, quarter / 0.3186)  # 25 % of a Gaussian lies within 0.3186 sd
