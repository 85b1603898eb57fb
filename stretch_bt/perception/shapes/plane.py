"""Plane fit to a face seen by a depth camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.robust_fit import Settled, robust_linear, settle, thinned
from stretch_bt.perception.shapes.sight import Noise, Sight, sighted
from stretch_bt.perception.types import FloatArray, Plane

__all__ = ["PlaneSurface", "fit_plane", "plane_of", "settle_plane"]

Array = npt.NDArray[np.float64]

PARAMETERS = 3


def fit_plane(points: FloatArray, *, rays: FloatArray | None = None, noise: Noise = None) -> Plane:
    """Fit a plane to points whose noise lies along the camera rays, robustly.

    Parameters
    ----------
    points : (n, 3) float, m
    rays : (n, 3) float, unit, or None
    noise : float, m, SurfaceNoise or None
        As for `fit_sphere`.

    Returns
    -------
    Plane

    Raises
    ------
    IllConditioned
        The points do not determine a plane.
    InvalidInput
        An array has the wrong shape, or the noise is not a positive number.
    """
    sight = sighted(points, rays, noise, name="plane", least=PARAMETERS + 1)
    return plane_of(settle_plane(sight), sight)


def settle_plane(sight: Sight) -> Settled[PlaneSurface]:
    """Fit a plane to points as the camera sees them."""
    x, y, z = thinned(sight)
    start, _ = robust_linear(np.stack([np.ones_like(x), x, y]), z, sight.floor, "plane")
    return settle(PlaneSurface(start), sight, "plane")


@dataclass(frozen=True, slots=True)
class PlaneSurface:
    """z = c + p1 x + p2 y, with `q` (3,) = (c, p1, p2)."""

    q: Array

    @property
    def parameters(self) -> int:
        """How many parameters there are."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (3, n)."""
        jacobian = np.stack([np.ones_like(x), x, y])
        return self.q @ jacobian, jacobian

    def moved(self, step: Array) -> tuple[PlaneSurface, Array]:
        """Return the plane after a step."""
        return PlaneSurface(self.q + step), step


def plane_of(settled: Settled[PlaneSurface], sight: Sight) -> Plane:
    """Return the plane in the caller's frame, m."""
    settled.check("plane")
    c, p1, p2 = settled.surface.q
    length = np.sqrt(1.0 + p1 * p1 + p2 * p2)
    normal = np.array([-p1, -p2, 1.0]) / length
    by_slopes = np.column_stack([np.zeros(3), [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]) / length
    by_slopes -= np.outer(normal, normal @ by_slopes)
    at = np.array([0.0, 0.0, c]) + sight.origin / sight.size
    by_offset = np.array([normal[2], 0.0, 0.0]) + at @ by_slopes
    return Plane(
        normal=sight.direction(normal),
        normal_sd=sight.spread(by_slopes, settled.covariance),
        offset=float(sight.size * (normal @ at)),
        offset_sd=float(sight.size * np.sqrt(max(by_offset @ settled.covariance @ by_offset, 0.0))),
    )
