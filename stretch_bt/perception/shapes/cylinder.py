"""Cylinder fit to a patch seen by a depth camera, with parameters that stay finite on a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.robust_fit import Settled, settle, start_of_few, thinned
from stretch_bt.perception.shapes.sight import Noise, Sight, sighted
from stretch_bt.perception.shapes.sphere import check_curvature
from stretch_bt.perception.shapes.turn import standing, turned
from stretch_bt.perception.types import Cylinder, FloatArray

__all__ = ["CylinderSurface", "cylinder_of", "fit_cylinder", "settle_cylinder"]

Array = npt.NDArray[np.float64]

PARAMETERS = 5
STEEPEST = 1e-4  # least squared cosine between ray and normal; beyond it is the silhouette
LARGEST_TURN = 0.3  # rad a step
WIDEST = 0.95  # sine of the half angle that the points may span at the start


def fit_cylinder(points: FloatArray, *, rays: FloatArray | None = None, noise: Noise = None) -> Cylinder:
    """Fit the curved side of a cylinder to points whose noise lies along the camera rays, robustly.

    Parameters
    ----------
    points : (n, 3) float, m
    rays : (n, 3) float, unit, or None
    noise : float, m, SurfaceNoise or None
        As for `fit_sphere`.

    Returns
    -------
    Cylinder

    Raises
    ------
    IllConditioned
        The points do not determine a cylinder, or its curvature is below three standard deviations, or below ten where
        only the residuals show that neighbouring points share their errors.
    InvalidInput
        An array has the wrong shape, or the noise is not a positive number.
    """
    sight = sighted(points, rays, noise, name="cylinder", least=PARAMETERS + 1)
    return cylinder_of(settle_cylinder(sight), sight)


def settle_cylinder(sight: Sight) -> Settled[CylinderSurface]:
    """Fit a cylinder to points as the camera sees them, from the larger curvature of a quadric."""
    x, y, z = thinned(sight)
    design = np.stack([np.ones_like(x), x, y, -0.5 * x * x, -x * y, -0.5 * y * y])
    c, p1, p2, kxx, kxy, kyy = start_of_few(design, z, sight.floor, "cylinder")
    values, vectors = np.linalg.eigh([[kxx, kxy], [kxy, kyy]])
    across, along = vectors[:, ::-1].T if abs(values[1]) >= abs(values[0]) else vectors.T
    reach = float(np.abs(across @ np.stack([sight.x, sight.y])).max())
    curvature = float(np.clip(across @ np.array([[kxx, kxy], [kxy, kyy]]) @ across, -WIDEST / reach, WIDEST / reach))
    axes = standing(np.array([-p1, -p2, 1.0]), np.array([along[0], along[1], along @ [p1, p2]]))
    return settle(CylinderSurface(float(c), axes, curvature), sight, "cylinder")


@dataclass(frozen=True, slots=True)
class CylinderSurface:
    """The root z of k ((w b)^2 + (w n)^2) + 2 w n = 0 for w = (x, y, z - c) that stays finite at curvature k = 0.

    `axes` (3, 3) has as rows the direction a of the axis, b and the normal n of the surface at the origin. A step is
    (c, rotation about a, b and n, k).
    """

    c: float
    axes: Array
    k: float

    @property
    def parameters(self) -> int:
        """How many parameters a step has."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (5, n) by a step."""
        (a1, a2, a3), (b1, b2, b3), (n1, n2, n3) = self.axes
        k = self.k
        across, above = b1 * x + b2 * y, n1 * x + n2 * y
        half = k * (across * b3 + above * n3) + n3
        ends = k * (across * across + above * above) + 2.0 * above
        root = np.sqrt(np.maximum(half * half - k * (b3 * b3 + n3 * n3) * ends, STEEPEST))
        z = -ends / np.maximum(half + root, np.sqrt(STEEPEST))  # less is beyond the silhouette
        wa, wb, wn = a1 * x + a2 * y + a3 * z, across + b3 * z, above + n3 * z
        # Half the derivatives of the equation by c, the rotations and k; by z it is the root.
        by_step = np.stack([-root, -wb, (k * wn + 1.0) * wa, -k * wa * wb, 0.5 * (wb * wb + wn * wn)])
        return self.c + z, -by_step / root

    def moved(self, step: Array) -> tuple[CylinderSurface, Array]:
        """Return the cylinder after a step; the curvature moves at most by half its value."""
        share = min(
            1.0,
            0.5 * max(abs(self.k), 0.05) / max(abs(float(step[4])), 1e-300),
            LARGEST_TURN / max(float(np.abs(step[1:4]).max()), 1e-300),
        )
        taken = step * share
        return CylinderSurface(self.c + taken[0], turned(self.axes, taken[1:4]), self.k + taken[4]), taken


def cylinder_of(settled: Settled[CylinderSurface], sight: Sight) -> Cylinder:
    """Return the cylinder in the caller's frame, m, or refuse one without a clear curvature."""
    settled.check_errors("cylinder")
    surface = settled.surface
    k, sd = surface.k, settled.sd(4)
    check_curvature(k, sd, alike=settled.area > 1.0 and not settled.explained)
    settled.check_settled("cylinder")  # last, as the axis of a plane goes round for ever
    a, b, n = surface.axes
    middle = np.array([0.0, 0.0, surface.c])
    by_point = np.column_stack([[0.0, 0.0, 1.0], b / k, -a / k, np.zeros(3), n / k**2])
    by_axis = np.column_stack([np.zeros(3), np.zeros(3), -n, b, np.zeros(3)])
    return Cylinder(
        radius=float(sight.size / abs(k)),
        radius_sd=float(sight.size * sd / k**2),
        axis=sight.direction(a),
        axis_sd=sight.spread(by_axis, settled.covariance),
        point=sight.place(middle - n / k),
        point_sd=sight.size * sight.spread(by_point, settled.covariance),
        curvature=float(k / sight.size),
        curvature_sd=sd / sight.size,
    )
