"""Cone fit to a patch seen by a depth camera: its apex, its axis and how steep it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.shapes.robust_fit import Settled, robust_linear, settle, thinned
from stretch_bt.perception.shapes.sight import Noise, Sight, sighted
from stretch_bt.perception.shapes.turn import standing, turned
from stretch_bt.perception.types import Cone, FloatArray

__all__ = ["ConeSurface", "cone_of", "fit_cone", "settle_cone"]

Array = npt.NDArray[np.float64]

PARAMETERS = 6
SIGNIFICANCE = 3.0  # an angle below this many standard deviations is a plane's
FLAT = 1e-4  # sine of the angle below which a cone is a plane to any sensor
STEEPEST = 0.97  # sine of the angle over that at which the camera no longer sees the far side
LARGEST_STEP = 0.3  # lateral sizes, and rad, a step
PLACES = 9  # along each side of the grid of places at which an apex is tried
FAR = 3.0  # lateral sizes from the middle to the edge of that grid
BLUNT = 1e-9  # of the lateral size: a tip this round keeps the derivatives finite at the apex


def fit_cone(points: FloatArray, *, rays: FloatArray | None = None, noise: Noise = None) -> Cone:
    """Fit a cone to points whose noise lies along the camera rays, robustly, so that a rounded tip does little harm.

    Parameters
    ----------
    points : (n, 3) float, m
    rays : (n, 3) float, unit, or None
    noise : float, m, SurfaceNoise or None
        As for `fit_sphere`.

    Returns
    -------
    Cone

    Raises
    ------
    IllConditioned
        The points do not determine a cone, its angle is below three standard deviations, or its apex may be anywhere.
    InvalidInput
        An array has the wrong shape, or the noise is not a positive number.
    """
    sight = sighted(points, rays, noise, name="cone", least=PARAMETERS + 1)
    return cone_of(settle_cone(sight), sight)


def settle_cone(sight: Sight) -> Settled[ConeSurface]:
    """Fit a cone to points as the camera sees them, from the best of a grid of upright cones."""
    x, y, z = thinned(sight)
    at = _likely_apex(x, y, z, sight.floor)
    design = np.stack([np.ones_like(x), x - at[0], y - at[1], -np.hypot(x - at[0], y - at[1])])
    c, p1, p2, steepness = robust_linear(design, z, sight.floor, "cone")[0]
    if abs(steepness) < FLAT:
        raise IllConditioned(
            "the points lie on a plane, which is no cone; press deeper, or measure a flat face (`measure_contact`)"
        )
    axes = standing(np.array([-p1, -p2, 1.0]), np.array([1.0, 0.0, 0.0]))
    sine = np.sin(np.arctan(steepness))
    limit = STEEPEST * axes[2, 2]
    surface = ConeSurface(np.array([*at, c]), axes, float(np.clip(sine, -limit, limit)))
    return settle(surface, sight, "cone")


def _likely_apex(x: Array, y: Array, z: Array, floor: float) -> Array:
    """Return the place (2,) on a grid from which z falls or rises most like a cone, by least absolute residuals."""
    quadric = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    _, weights = robust_linear(quadric, z, floor, "cone")
    side = np.linspace(-FAR, FAR, PLACES)
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    for finer in (4.0, 4.0, None):
        slant = np.hypot(x - places[:, :1], y - places[:, 1:])
        designs = np.stack(np.broadcast_arrays(np.ones_like(slant), x, y, -slant), axis=1)
        weighted = designs * weights
        normal = weighted @ designs.transpose(0, 2, 1) + 1e-12 * np.eye(4)
        solutions = np.linalg.solve(normal, (weighted @ z)[..., None])
        misfit = (weights * np.abs(z - (solutions * designs).sum(axis=1))).sum(axis=1)
        best = places[int(np.argmin(misfit))]
        if finer is not None:
            side = side / finer
            places = best + np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    return np.asarray(best)


@dataclass(frozen=True, slots=True)
class ConeSurface:
    """The height at which w d = -s |w|, w from the `apex` (3,), d the axis towards the camera, s the sine of the angle.

    `axes` (3, 3) has two directions across the axis and d as rows. A step is (apex, rotation about the first two, s).
    """

    apex: Array
    axes: Array
    s: float

    @property
    def parameters(self) -> int:
        """How many parameters a step has."""
        return PARAMETERS

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (6, n) by a step."""
        a, b, d = self.axes
        x, y = x - self.apex[0], y - self.apex[1]
        r2 = x * x + y * y + BLUNT**2
        across = d[0] * x + d[1] * y
        seen = d[2] ** 2 - self.s**2
        z = (-across * d[2] - self.s * np.sqrt(across * across + seen * r2)) / seen
        w = np.stack([x, y, z])
        length = np.sqrt(r2 + z * z)
        gradient = d[:, None] + self.s * w / length
        by_step = np.concatenate([-gradient, [-(b @ w), a @ w, length]])
        return self.apex[2] + z, -by_step / gradient[2]

    def moved(self, step: Array) -> tuple[ConeSurface, Array]:
        """Return the cone after a step, kept less steep than the camera's view."""
        taken = step * min(1.0, LARGEST_STEP / max(float(np.abs(step).max()), 1e-300))
        axes = turned(self.axes, np.array([taken[3], taken[4], 0.0]))
        limit = STEEPEST * axes[2, 2]
        return ConeSurface(self.apex + taken[:3], axes, float(np.clip(self.s + taken[5], -limit, limit))), taken


def cone_of(settled: Settled[ConeSurface], sight: Sight) -> Cone:
    """Return the cone in the caller's frame, m, or refuse one without a clear angle or apex."""
    settled.check("cone")
    surface = settled.surface
    s, sd = surface.s, settled.sd(5)
    if abs(s) < FLAT or abs(s) < SIGNIFICANCE * sd:
        raise IllConditioned(
            f"the points carry no cone: its angle is {np.degrees(s):.2g} deg +- {np.degrees(sd):.2g}, not clearly apart from a plane's;"
            " press deeper, or average more frames"
        )
    a, b, d = surface.axes
    by_apex = np.eye(3, PARAMETERS)
    by_axis = np.column_stack([np.zeros((3, 3)), -b, a, np.zeros(3)])
    apex_sd = sight.spread(by_apex, settled.covariance)
    reach = float(np.sqrt((sight.x**2 + sight.y**2).max()))
    if float(apex_sd.max()) > reach:
        raise IllConditioned(
            "the points show no apex, so that a cone that ends anywhere explains them; press until the tip touches, or fit a cylinder"
        )
    return Cone(
        angle=float(np.arcsin(s)),
        angle_sd=float(sd / np.sqrt(1.0 - s * s)),
        apex=sight.place(surface.apex),
        apex_sd=sight.size * apex_sd,
        axis=sight.direction(d),
        axis_sd=sight.spread(by_axis, settled.covariance),
    )
