"""Sphere fit to a cap seen by a depth camera: residuals along the rays, parameters that stay finite on a plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.perception.robust import TUKEY, scale_of, tukey_psi_slope, tukey_weights
from stretch_bt.perception.types import FloatArray, Sphere

__all__ = ["fit_sphere"]

Array = npt.NDArray[np.float64]

SIGNIFICANCE = 3.0  # a curvature below this many standard deviations carries no radius
FLAT = 1e-4  # curvature times lateral size below which a surface is a plane to any sensor
THIN = 1e-5  # width over length, seen from the camera, below which points lie on a line
PARAMETERS = 4
START = 400  # points that are enough to start from


def fit_sphere(points: FloatArray, *, rays: FloatArray | None = None, noise: float | None = None) -> Sphere:
    """Fit a sphere to points whose noise lies along the camera rays.

    The surface is z = c + N / (D + D0) with offset c, slopes (p1, p2) and curvature k at the lateral median, where
    N = 2 (sx x + sy y) - k (x^2 + y^2), D^2 = 1 - (k x - sx)^2 - (k y - sy)^2, D0 = 1 / sqrt(1 + p1^2 + p2^2) and
    s = p D0. Tukey's biweight bounds the influence of outliers. Orthogonal and algebraic fits are biased to small
    radii on small caps, because they take the noise to be isotropic.

    Parameters
    ----------
    points : (n, 3) float, m
        Any frame; rows that are not finite are left out, exact duplicates count once.
    rays : (n, 3) float, unit, or None
        From the camera through each point. A sphere is convex where its centre lies beyond the points along the rays.
        By default the camera looks along -z, as in the membrane frame.
    noise : float, m, or None
        Standard deviation of one point along its ray, if known; the residuals may show more, never less.

    Returns
    -------
    Sphere
        Standard deviations hold for noise that is independent from point to point.

    Raises
    ------
    IllConditioned
        The points do not determine a sphere, or its curvature is below three standard deviations.
    InvalidInput
        An array has the wrong shape, or the noise is not a positive number.
    """
    kept, directions = _checked(points, rays, noise)
    frame = _ray_frame(directions)
    local = kept @ frame.T
    origin = np.median(local, axis=0)
    local -= origin
    size = _lateral_size(local, np.abs(kept).max())
    x, y, z = (local / size).T
    floor = max(noise or 0.0, 4.0 * np.finfo(np.float64).eps * float(np.abs(kept).max())) / size
    every = max(1, len(x) // START)
    start = _paraboloid(x[::every], y[::every], z[::every], floor)
    parameters = _refine(start, x, y, z, floor)
    covariance = _covariance(parameters, x, y, z, floor)
    return _sphere(parameters, covariance, size, origin, frame)


def _checked(points: FloatArray, rays: FloatArray | None, noise: float | None) -> tuple[Array, Array]:
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"fit_sphere needs points of shape (n, 3) in m, got {array.shape}")
    if noise is not None and not (np.isfinite(noise) and noise > 0):
        raise InvalidInput(f"noise is a positive standard deviation in m, got {noise}")
    if rays is None:
        directions = np.broadcast_to(np.array([0.0, 0.0, -1.0]), array.shape)
    else:
        directions = np.asarray(rays, dtype=np.float64)
        if directions.shape != array.shape:
            raise InvalidInput(f"rays need the shape of the points, {array.shape}, got {directions.shape}")
    finite = np.isfinite(array).all(axis=1) & np.isfinite(directions).all(axis=1)
    kept, directions = _distinct(array[finite], directions[finite])
    if len(kept) <= PARAMETERS:
        raise IllConditioned(f"a sphere with its error needs at least five distinct points, there are {len(kept)}")
    return kept, directions


def _distinct(points: Array, directions: Array) -> tuple[Array, Array]:
    """Drop repeated points: they carry no information and would make the error look smaller than it is."""
    order = np.lexsort(points.T)
    ranked = points[order]
    first = np.ones(len(order), dtype=bool)
    first[1:] = (ranked[1:] != ranked[:-1]).any(axis=1)
    return ranked[first], directions[order][first]


def _ray_frame(directions: Array) -> Array:
    """Return the (3, 3) rotation whose third row points from the surface to the camera."""
    mean = -directions.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 0.1:
        raise InvalidInput("rays are unit vectors from one camera; these point in opposite directions")
    z = mean / length
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def _lateral_size(local: Array, magnitude: float) -> float:
    """Return the rms distance from the origin across the rays, or refuse points on a line or at one place."""
    narrow, wide = np.sqrt(np.linalg.eigvalsh(np.cov(local[:, :2].T, bias=True)).clip(0.0))
    if wide <= 1e-13 * magnitude or wide == 0.0:
        raise IllConditioned("the points coincide as the camera sees them")
    if narrow < THIN * wide:
        raise IllConditioned("the points lie on one line as the camera sees them")
    return float(np.hypot(narrow, wide))


def _solve(matrix: Array, right: Array) -> Array:
    """Solve the normal equations, or refuse where the points leave a parameter free."""
    diagonal = np.sqrt(np.diag(matrix).clip(1e-300))
    values, vectors = np.linalg.eigh(matrix / np.outer(diagonal, diagonal))
    if values[0] < 1e-11:
        raise IllConditioned(
            "the points leave the sphere free: they lie on too few distinct lines of sight or on a ring"
        )
    return np.asarray(vectors @ (vectors.T @ (right / diagonal) / values) / diagonal, dtype=np.float64)


def _paraboloid(x: Array, y: Array, z: Array, floor: float) -> Array:
    """Return (c, p1, p2, k) of a paraboloid by least absolute residuals, a convex problem, then Tukey's weights."""
    design = np.column_stack([np.ones_like(x), x, y, -0.5 * (x * x + y * y)])
    weights = np.ones_like(x)
    solution = np.zeros(PARAMETERS)
    for step in range(9):
        weighted = design * weights[:, None]
        solution = _solve(weighted.T @ design, weighted.T @ z)
        residuals = z - design @ solution
        scale = max(scale_of(residuals, PARAMETERS), floor)
        weights = 1.0 / np.maximum(np.abs(residuals), 0.1 * scale)
        if step >= 5:
            weights = tukey_weights(residuals / (TUKEY * scale))
    return solution


def _model(q: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return the height (n,) of the sphere and its Jacobian (4, n) by (c, p1, p2, k)."""
    c, p1, p2, k = q
    d0 = 1.0 / np.sqrt(1.0 + p1 * p1 + p2 * p2)
    sx, sy = p1 * d0, p2 * d0
    ux, uy = k * x - sx, k * y - sy
    r2 = x * x + y * y
    square = 1.0 - ux * ux - uy * uy
    d = np.sqrt(np.maximum(square, 1e-4))
    inner = (square > 1e-4) / d  # beyond the silhouette the surface continues at constant D
    total = d + d0
    f = (2.0 * (sx * x + sy * y) - k * r2) / total
    by_sx = (2.0 * x - f * (ux * inner - sx / d0)) / total
    by_sy = (2.0 * y - f * (uy * inner - sy / d0)) / total
    by_k = (-r2 + f * (ux * x + uy * y) * inner) / total
    jacobian = np.empty((PARAMETERS, x.size))
    jacobian[0] = 1.0
    jacobian[1] = d0 * ((1.0 - sx * sx) * by_sx - sx * sy * by_sy)
    jacobian[2] = d0 * ((1.0 - sy * sy) * by_sy - sx * sy * by_sx)
    jacobian[3] = by_k
    return c + f, jacobian


def _refine(q: Array, x: Array, y: Array, z: Array, floor: float) -> Array:
    """Iterate reweighted Gauss-Newton from the paraboloid; curvature moves at most by half its value a step."""
    reach = float(np.sqrt((x * x + y * y).max()))
    q = q.copy()
    q[3] = np.clip(q[3], -0.95 / reach, 0.95 / reach)
    for _ in range(30):
        height, jacobian = _model(q, x, y)
        residuals = z - height
        scale = max(scale_of(residuals, PARAMETERS), floor)
        weighted = jacobian * tukey_weights(residuals / (TUKEY * scale))
        step = _solve(weighted @ jacobian.T, weighted @ residuals)
        limit = 0.5 * max(abs(q[3]), 0.05)
        step *= min(1.0, limit / max(abs(step[3]), 1e-300))
        q += step
        if np.abs(step).max() < 1e-2 * max(scale / np.sqrt(x.size), 1e-12):
            break
    return q


def _covariance(q: Array, x: Array, y: Array, z: Array, floor: float) -> Array:
    """Return the covariance (4, 4) of an M-estimate (Huber, Robust Statistics, 1981, section 7.6)."""
    height, jacobian = _model(q, x, y)
    residuals = z - height
    scale = max(scale_of(residuals, PARAMETERS), floor)
    u = residuals / (TUKEY * scale)
    inside = np.abs(u) < 1.0
    count = int(inside.sum())
    if count <= PARAMETERS:
        raise IllConditioned("no sphere agrees with more than four of the points")
    psi = u[inside] * tukey_weights(u[inside])
    spread = float(psi @ psi) / (count - PARAMETERS)
    variance = spread / max(float(tukey_psi_slope(u[inside]).mean()), 0.1) ** 2 * (TUKEY * scale) ** 2
    kept = jacobian[:, inside]
    information = kept @ kept.T
    _solve(information, np.zeros(PARAMETERS))
    return np.asarray(np.linalg.inv(information) * max(variance, floor**2), dtype=np.float64)


def _sphere(q: Array, covariance: Array, size: float, origin: Array, frame: Array) -> Sphere:
    """Turn (c, p1, p2, k), in units of `size`, into a sphere in the caller's frame."""
    c, p1, p2, k = q
    k_sd = float(np.sqrt(covariance[3, 3]))
    if abs(k) < FLAT:
        raise IllConditioned("the points lie on a plane")
    if abs(k) < SIGNIFICANCE * k_sd:
        raise IllConditioned(
            f"the cap carries no radius: its curvature is only {abs(k) / k_sd:.1f} standard deviations from a plane"
        )
    d0 = 1.0 / np.sqrt(1.0 + p1 * p1 + p2 * p2)
    d3 = d0**3
    center = np.array([p1 * d0 / k, p2 * d0 / k, c - d0 / k])
    by_parameters = np.array(
        [
            [0.0, (1 + p2 * p2) * d3 / k, -p1 * p2 * d3 / k, -p1 * d0 / k**2],
            [0.0, -p1 * p2 * d3 / k, (1 + p1 * p1) * d3 / k, -p2 * d0 / k**2],
            [1.0, p1 * d3 / k, p2 * d3 / k, d0 / k**2],
        ]
    )
    rotated = frame.T @ by_parameters
    center_sd = size * np.sqrt(np.diag(rotated @ covariance @ rotated.T))
    return Sphere(
        radius=float(size / abs(k)),
        radius_sd=float(size * k_sd / k**2),
        center=frame.T @ (center * size + origin),
        center_sd=center_sd,
        curvature=float(k / size),
        curvature_sd=k_sd / size,
    )
