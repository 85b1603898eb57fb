"""Sphere fit to a cap seen by a depth camera: residuals along the rays, parameters that stay finite on a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.robust_fit import Settled, settle, solve, start_of_few, thinned
from stretch_bt.perception.shapes.sight import Noise, Sight, sighted
from stretch_bt.perception.shapes.sphere_kernel import fill_sphere
from stretch_bt.perception.types import FloatArray, Sphere

__all__ = ["SphereSurface", "center_of", "fit_sphere", "settle_sphere", "sphere_of"]

Array = npt.NDArray[np.float64]

SIGNIFICANCE = 3.0  # a curvature below this many standard deviations carries no radius
ALIKE_SIGNIFICANCE = 10.0  # the same where neighbours share errors, and their deviation is only roughly known
SILHOUETTE = 0.99  # radii from the line of sight through its centre, within which a sphere shows points
NOISY = 0.02  # noise over radius from which a sphere whose points reach its silhouette may be one of noise
FLAT = 1e-4  # curvature times lateral size below which a surface is a plane to any sensor
PARAMETERS = 4


def fit_sphere(points: FloatArray, *, rays: FloatArray | None = None, noise: Noise = None) -> Sphere:
    """Fit a sphere to points whose noise lies along the camera rays.

    Each point counts as likely as it is no outlier. Orthogonal and algebraic fits are biased to small radii on small
    caps, because they take the noise to be isotropic.

    Parameters
    ----------
    points : (n, 3) float, m
        Any frame; rows that are not finite are left out, exact duplicates count once. Any unit of length serves; the sphere is in the unit
        of the points, and so must be `noise`: nothing here distinguishes millimetres from metres.
    rays : (n, 3) float, unit, or None
        Directions from the camera through each point. A sphere is convex where its centre lies beyond the points along the rays.
        By default the camera looks along -z, as in the membrane frame.
    noise : float, m, SurfaceNoise or None
        Standard deviation of one point along its ray, if known, and with `surface_noise` over how many neighbouring points
        it is alike; the residuals may show more, never less.

    Returns
    -------
    Sphere
        Its standard deviations include that neighbouring points share part of their error, as the residuals show it.

    Raises
    ------
    IllConditioned
        The points do not determine a sphere, or its curvature is below three standard deviations, or below ten where
        neighbouring points share their errors.
    InvalidInput
        An array has the wrong shape, or the noise is not a positive number.
    """
    sight = sighted(points, rays, noise, name="sphere", least=PARAMETERS + 1)
    return sphere_of(settle_sphere(sight), sight)


def settle_sphere(sight: Sight) -> Settled[SphereSurface]:
    """Fit a sphere to points as the camera sees them, starting from a paraboloid."""
    x, y, z = thinned(sight)
    design = np.stack([np.ones_like(x), x, y, -0.5 * (x * x + y * y)])
    start = start_of_few(design, z, sight.floor, "sphere")
    reach = float(np.sqrt((sight.x**2 + sight.y**2).max()))
    start[3] = np.clip(start[3], -0.95 / reach, 0.95 / reach)
    return settle(SphereSurface(start), sight, "sphere")


@dataclass(frozen=True, slots=True)
class SphereSurface:
    """z = c + N / (D + D0), with `q` (4,) the offset c, the slopes (p1, p2) and the curvature k at the origin.

    N = 2 (sx x + sy y) - k (x^2 + y^2), D^2 = 1 - (k x - sx)^2 - (k y - sy)^2, D0 = 1 / sqrt(1 + p1^2 + p2^2) and
    s = p D0: the root of k |w|^2 + 2 n w = 0 for w from the point at the origin, with unit normal n, that stays finite
    at k = 0.
    """

    q: Array

    @property
    def parameters(self) -> int:
        """How many parameters there are."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (4, n) by (c, p1, p2, k)."""
        height, jacobian = np.empty(x.size), np.empty((PARAMETERS, x.size))
        fill_sphere(self.q, x, y, height, jacobian)
        return height, jacobian

    def moved(self, step: Array) -> tuple[SphereSurface, Array]:
        """Return the surface after a step; the curvature moves at most by half its value."""
        limit = 0.5 * max(abs(float(self.q[3])), 0.05)
        taken = step * min(1.0, limit / max(abs(float(step[3])), 1e-300))
        return SphereSurface(self.q + taken), taken


def check_curvature(k: float, sd: float, *, alike: bool) -> None:
    """Refuse a curvature, in units of the lateral size, that is not clearly different from a plane's.

    `alike` says that neighbouring points share errors.
    """
    needed = ALIKE_SIGNIFICANCE if alike else SIGNIFICANCE
    if abs(k) < FLAT:
        raise IllConditioned(
            "the points lie on a plane, which has no radius; press deeper, or measure a flat face (`measure_contact`)"
        )
    if abs(k) < needed * sd:
        raise IllConditioned(
            f"the cap carries no radius: its curvature is only {abs(k) / sd:.1f} standard deviations from a plane, and"
            f" {needed:.0f} are needed"
            + (" where neighbouring points share their errors" if alike else "")
            + "; press deeper, or average more frames"
        )


def _gain_on_plane(settled: Settled[SphereSurface], sight: Sight) -> float:
    """Return by how many standard deviations the points that agree with a sphere prefer it to the best plane."""
    agreeing = np.abs(settled.residuals) < SIGNIFICANCE * settled.scale
    x, y, z = sight.x[agreeing], sight.y[agreeing], sight.z[agreeing]
    design = np.stack([np.ones_like(x), x, y])
    plane = solve(design @ design.T, design @ z, "sphere")
    left = float(np.sum((z - plane @ design) ** 2) - np.sum(settled.residuals[agreeing] ** 2))
    variance = max(settled.scale, sight.floor) ** 2 * max(settled.area, 1.0)
    return max(float(np.sqrt(max(left, 0.0) / variance)), 1e-3)


def _check_silhouette(settled: Settled[SphereSurface], sight: Sight) -> None:
    """Refuse a sphere whose points reach its silhouette: noise on a small cap makes such ones, and steep points fix no height."""
    _, p1, p2, k = settled.surface.q
    d0 = 1.0 / np.sqrt(1.0 + p1 * p1 + p2 * p2)
    away = np.hypot(k * sight.x - p1 * d0, k * sight.y - p2 * d0)
    agreeing = np.abs(settled.residuals) < SIGNIFICANCE * settled.scale
    if np.quantile(away[agreeing], 0.95) <= SILHOUETTE:
        return
    if settled.scale * abs(k) > NOISY:
        raise IllConditioned(
            "the points spread wider than the one sphere that they agree with, so that its radius comes from noise; press deeper, or"
            " average more frames"
        )
    raise IllConditioned(
        "the points reach the edge of the sphere as the camera sees it, where the least error across the view is a large one in"
        " height; leave out those whose normal is more than 80 degrees from the view"
    )


def center_of(q: Array) -> tuple[Array, Array]:
    """Return the centre (3,) of a SphereSurface and its derivatives (3, 4) by its parameters, in their unit."""
    c, p1, p2, k = q
    d0 = 1.0 / np.sqrt(1.0 + p1 * p1 + p2 * p2)
    d3 = d0**3
    by_parameters = [
        [0.0, (1 + p2 * p2) * d3 / k, -p1 * p2 * d3 / k, -p1 * d0 / k**2],
        [0.0, -p1 * p2 * d3 / k, (1 + p1 * p1) * d3 / k, -p2 * d0 / k**2],
        [1.0, p1 * d3 / k, p2 * d3 / k, d0 / k**2],
    ]
    return np.array([p1 * d0 / k, p2 * d0 / k, c - d0 / k]), np.array(by_parameters)


def sphere_of(settled: Settled[SphereSurface], sight: Sight) -> Sphere:
    """Return the sphere in the caller's frame, m, or refuse one without a clear curvature."""
    settled.check("sphere")
    k, sd = settled.surface.q[3], settled.sd(3)
    # On few points of great noise the tangent at the best curvature promises more than the points can show.
    check_curvature(
        k, max(sd, abs(k) / _gain_on_plane(settled, sight)), alike=settled.area > 1.0 and not settled.explained
    )
    _check_silhouette(settled, sight)
    center, by_parameters = center_of(settled.surface.q)
    return Sphere(
        radius=float(sight.size / abs(k)),
        radius_sd=float(sight.size * sd / k**2),
        center=sight.place(center),
        center_sd=sight.size * sight.spread(by_parameters, settled.covariance),
        curvature=float(k / sight.size),
        curvature_sd=sd / sight.size,
    )
