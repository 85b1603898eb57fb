"""Robust least squares along the camera rays, for any surface that gives its height and derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.robust import scale_of
from stretch_bt.perception.shapes.correlation import correlation_area
from stretch_bt.perception.shapes.inliers import Inliers
from stretch_bt.perception.shapes.inliers_kernel import normal_step, settle_line
from stretch_bt.perception.shapes.sight import Sight

__all__ = ["Settled", "SightSurface", "robust_linear", "settle", "solve", "thinned"]

Array = npt.NDArray[np.float64]

START = 400  # points that are enough to start from
FEW, DRAWS = (
    60,
    300,
)  # points, of which outliers may mislead a start by least absolute residuals; fits through some of them
CLEARLY = 0.5  # share of the bound that half of the residuals of the first start stay below: a drawn start is taken only below it
NEAR = 2.5  # times the bound that half of the residuals stay below, up to which points count
PASSES = 2  # over where rays meet a surface; each leaves a tenth of the error of the last
STEPS = 200  # most fits settle in five
TRUSTED = 10  # whole steps, after which a share of a step is taken, halved where it turns back
LEAST_SHARE = 1 / 16  # of a step
CLOSE = 0.03  # share of the standard deviation of a mean that an answer may still move by
UNSETTLED = 0.3  # the same after all steps: a slow end adds less than a twentieth to the error
ROUNDING = 100.0  # units of the resolution up to which residuals are rounding errors
FAR = 1e3  # lateral sizes beyond which a step comes from a nearly singular matrix
SINGULAR = 1e-11  # least eigenvalue of equilibrated normal equations
EXPLAINED = 4.0  # times its variance, up to which noise that is known from elsewhere explains residuals
PATCHES = (
    3.0  # independent errors that each parameter needs, so that the error of a fit can be estimated from its residuals
)


class SightSurface(Protocol):
    """A surface over (x, y) in the frame of a Sight, with parameters that a step can move."""

    @property
    def parameters(self) -> int:
        """How many parameters a step has."""

    def heights(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Return the height (n,) and its derivatives (p, n) by a step's parameters."""

    def moved(self, step: Array) -> tuple[Self, Array]:
        """Return the surface after a step (p,), shortened where it would leave what is meaningful, and that step."""


S = TypeVar("S", bound=SightSurface)


@dataclass(frozen=True, slots=True)
class Settled(Generic[S]):
    """A fitted surface, the covariance (p, p) of its parameters, and the residuals (n,) with their scale.

    `area` is the number of points that share one error; the covariance counts it in. `agreeing` is how many points are
    no outliers. `explained` says that noise which is known to be there explains the error that neighbours share. `moving` is the last step
    over the standard deviation of a mean.
    """

    surface: S
    covariance: Array
    residuals: Array
    scale: float
    area: float
    agreeing: float
    explained: bool
    moving: float = 0.0

    def check(self, name: str) -> None:
        """Refuse a fit that still moves, or whose errors are too alike for the residuals to show how large they are."""
        self.check_settled(name)
        self.check_errors(name)

    def check_settled(self, name: str) -> None:
        """Refuse a fit that still moves."""
        if self.moving >= UNSETTLED:
            raise IllConditioned(
                f"the {name} does not settle on the points: after {STEPS} steps it still moves by {self.moving:.2g} of the standard deviation of"
                f" a mean, and {UNSETTLED:g} is allowed; fit another shape (`fit_shape`), press deeper, or average more frames"
            )

    def check_errors(self, name: str) -> None:
        """Refuse a fit whose errors are too alike for the residuals to show how large they are."""
        if not self.explained and self.area > 1.0 and self.agreeing < PATCHES * self.surface.parameters * self.area:
            alike = f"about {self.area:.0f}" if self.area < self.agreeing else "most"
            raise IllConditioned(
                f"the contact differs from a {name} by the same amount over {alike} of its {self.agreeing:.0f} points: it is no {name}, or the"
                f" camera's errors are as wide as the contact, so that no error of the {name} can be given; fit another shape"
                " (`fit_shape`), press deeper, or average more frames"
            )

    def sd(self, parameter: int) -> float:
        """Return the standard deviation of one parameter."""
        return float(np.sqrt(self.covariance[parameter, parameter]))


def solve(matrix: Array, right: Array, name: str) -> Array:
    """Solve the normal equations of a shape, or refuse where the points leave one of its parameters free."""
    diagonal = np.sqrt(np.diag(matrix).clip(1e-300))
    values, vectors = np.linalg.eigh(matrix / (diagonal[:, None] * diagonal))
    if values[0] < SINGULAR:
        raise IllConditioned(
            f"the points lie on a ring or on few lines of sight, so that many a {name} passes through them; press deeper, so that a"
            " whole area touches"
        )
    scaled = vectors / diagonal[:, None]
    return np.asarray(scaled @ ((scaled.T @ right).T / values).T)


def _step(jacobian: Array, weights: Array, residuals: Array, name: str) -> Array:
    """Return the step of weighted least squares, or refuse as `solve` does; that alone is slow, and seldom needed."""
    step = np.empty(len(jacobian))
    if normal_step(jacobian, weights, residuals, step) and np.abs(step).max() < FAR:
        return step
    weighted = jacobian * weights
    return solve(weighted @ jacobian.T, weighted @ residuals, name)


def thinned(sight: Sight) -> tuple[Array, Array, Array]:
    """Return x, y and z of about as many points as are enough to start from."""
    every = max(1, sight.x.size // START)
    return sight.x[::every], sight.y[::every], sight.z[::every]


def robust_linear(design: Array, z: Array, floor: float, name: str) -> tuple[Array, Array]:
    """Return the solution (p,) and weights (n,) of z = solution @ design (p, n).

    First by least absolute residuals, a convex problem that needs no start, then with Tukey's weights.
    """
    solution, weights = np.empty(len(design)), np.empty(len(z))
    if not settle_line(design, np.ascontiguousarray(z), floor, solution, weights) or np.abs(solution).max() >= FAR:
        solve((design * weights) @ design.T, design @ (weights * z), name)
    return solution, weights


def start_of_few(design: Array, z: Array, floor: float, name: str) -> Array:
    """Return the solution (p,) of z = solution @ design (p, n) to start from, also where a few of few points are outliers.

    Of few points each pulls hard at a solution of least absolute residuals. So the least of the residuals that half of the points stay
    below decides between it and exact fits through drawn points (Rousseeuw, Least Median of Squares Regression, 1984).
    """
    solution = robust_linear(design, z, floor, name)[0]
    p, n = design.shape
    if n > FEW:
        return solution
    rng = np.random.default_rng(0)
    drawn = np.argsort(rng.random((DRAWS, n)), axis=1)[:, :p]
    through = design[:, drawn].transpose(1, 2, 0)
    with np.errstate(all="ignore"):  # of numbers next to 0 or endless, whose fits are none
        sound = np.abs(np.linalg.det(through)) > 0.0
        exact = np.linalg.solve(through[sound], z[drawn[sound]][..., None])[..., 0]
        found = np.vstack([solution[None], exact])
        left = np.nan_to_num(np.abs(z - found @ design), nan=np.inf, posinf=np.inf)
    half = np.partition(left, (n + p + 1) // 2 - 1, axis=1)[:, (n + p + 1) // 2 - 1]
    best = int(np.argmin(half))
    if half[best] > CLEARLY * half[0]:
        return solution
    near = left[best] <= max(NEAR * float(half[best]), floor)
    return np.asarray(np.linalg.lstsq(design[:, near].T, z[near], rcond=None)[0])


def settle(surface: S, sight: Sight, name: str) -> Settled[S]:
    """Iterate weighted Gauss-Newton from a robust start, and return where it settles, with its error.

    Noise moves a point along its own ray, so across as well where rays are not parallel: the surface is held against a
    point where its ray meets the surface, found by fixed-point iteration.

    Raises
    ------
    IllConditioned
        The points leave a parameter free, or too few agree. `Settled.check` refuses one that still moves, so that others can be compared with it.
    """
    met, found = sight, _iterated(surface, sight, name)
    for _ in range(PASSES if sight.lean is not None else 0):
        met = sight.moved_to(found[2])
        found = _iterated(found[0], met, name)
    return _with_error(met, name, *found)


def _iterated(surface: S, sight: Sight, name: str) -> tuple[S, Inliers, Array, Array, float]:
    """Return where a surface settles, the mixture of the residuals (n,), these, the derivatives (p, n), and the last step.

    Weights follow residuals, so that a step may go to and fro for ever: then ever smaller shares of it are taken. The last step is the
    whole one, over the standard deviation of a mean.
    """
    p, share, before, moving = surface.parameters, 1.0, np.zeros(surface.parameters), math.inf
    height, jacobian = surface.heights(sight.x, sight.y)
    residuals = sight.z - height
    inliers = Inliers.first(residuals, p, sight.floor)
    for number in range(STEPS):
        weights = inliers.weights(residuals)
        whole = _step(jacobian, weights, residuals, name)
        if number >= TRUSTED and whole @ before < 0.0:
            share = max(0.5 * share, LEAST_SHARE)
        before = whole
        surface, step = surface.moved(share * whole)
        height, jacobian = surface.heights(sight.x, sight.y)
        residuals = sight.z - height
        far = float(np.abs(step).max()) / share
        # While the surface still moves, its misfit is no noise, and what fits it worse no outlier.
        wrong = far > inliers.scale
        inliers = (
            Inliers.first(residuals, p, sight.floor) if wrong else inliers.next(residuals, weights, p, sight.floor)
        )
        moving = far / max(inliers.scale / math.sqrt(residuals.size), 1e-12)
        if moving < CLOSE:
            break
    return surface, inliers, residuals, jacobian, moving


def _with_error(
    sight: Sight, name: str, surface: S, inliers: Inliers, residuals: Array, jacobian: Array, moving: float
) -> Settled[S]:
    p = surface.parameters
    weights = inliers.weights(residuals)
    total = float(weights.sum())
    inside = weights > 0.5
    if inside.sum() <= p or total <= p + 0.5:
        raise IllConditioned(
            f"at most {p} of the {len(residuals)} points lie on one {name}, too few to rule out chance; the object is no {name}, or"
            " the noise is large: fit another shape (`fit_shape`), or average more frames"
        )
    area = _area(sight, residuals, inside, p)
    inverse = solve((jacobian * weights) @ jacobian.T, np.eye(p), name)
    freedom = total - p
    # of few residuals the noise is not well known: the deviation of Student's t
    spread = inliers.spread(residuals, weights, p) * freedom / max(freedom - 2.0, 0.5)
    variance, known = spread * min(area, total), sight.floor**2 * sight.alike
    # A few errors show their size well enough, but not over how many points each is alike; the rest of the frame does.
    explained = sight.alike > 1.0 and spread < EXPLAINED * sight.floor**2
    if explained:
        variance, area = max(spread, sight.floor**2) * sight.alike, 1.0
    elif variance < known:  # the residuals share less than the noise that is known to be there
        variance, area = known, 1.0
    area = max(area, sight.alike)
    return Settled(surface, inverse * variance, residuals, inliers.scale, area, total, explained, moving)


def _area(sight: Sight, residuals: Array, inside: npt.NDArray[np.bool_], p: int) -> float:
    """Return how many points share one error; rounding errors are alike wherever the shape is, and say nothing."""
    if scale_of(residuals[inside]) <= ROUNDING * sight.resolution:
        return 1.0
    return correlation_area(sight.x[inside], sight.y[inside], residuals[inside], p)
