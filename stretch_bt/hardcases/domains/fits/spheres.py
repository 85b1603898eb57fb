"""Points of a cap with holes, twice, far away or with noise, and points that determine no sphere."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.perception import fit_plane, fit_sphere
from stretch_bt.perception.shapes.inliers import Inliers

SIDE = np.linspace(-5e-3, 5e-3, 20)
GRID = np.stack(np.meshgrid(SIDE, SIDE), axis=-1).reshape(-1, 2)
RING = np.column_stack([np.cos(np.arange(50)), np.sin(np.arange(50)), np.zeros(50)]) * 5e-3


def _with_height(height: Any) -> Any:
    return np.column_stack([GRID, np.broadcast_to(height, len(GRID))])


ROUND = _with_height(np.sqrt(0.015**2 - (GRID**2).sum(axis=1)))
NOISE = np.random.default_rng(5).normal(0, 0.3e-3, len(GRID))
NOISY = ROUND + np.column_stack([0 * NOISE, 0 * NOISE, NOISE / 10])
#: points, and a pattern of their refusal
REFUSED = {
    "four points": (ROUND[[0, 5, 210, 380]], "at least 5 distinct points, there are 4"),
    "four points many times": (np.tile(ROUND[[0, 5, 210, 380]], (50, 1)), "there are 4"),
    "a curve seen as a line": (
        np.column_stack([np.arange(50), 2 * np.arange(50), np.arange(50) ** 2]) * 1e-3,
        "one line",
    ),
    "a line in space": (np.outer(np.arange(50), [1e-3, 2e-3, 3e-3]), "one line"),
    "a ring": (RING, "ring"),
    "an exact level plane": (_with_height(0.01), "plane"),
    "an exact tilted plane": (_with_height(0.3 * GRID[:, 0] - 0.1 * GRID[:, 1]), "plane"),
    "a noisy plane": (_with_height(NOISE), "standard deviations"),
    "a cap too small for its noise": (_with_height(ROUND[:, 2] / 30 + NOISE), "standard deviations"),
}


def _holes(points: Any) -> Any:
    out = np.vstack([points, points[:40]])
    out[:20, 2], out[20:40, 0] = np.nan, np.inf
    return out


#: points, radius, and how well it is found
FOUND: dict[str, tuple[Any, float, float]] = {
    "NaN and inf rows beside": (_holes(ROUND), 0.015, 1e-6),
    "each point twice": (np.vstack([ROUND, ROUND]), 0.015, 1e-6),
    "1e6 mm aside": (ROUND + np.array([1e3, -1e3, 1e3]), 0.015, 1e-4),
    "1e6 mm aside in float32, as mm": ((ROUND * 1e3 + 1e6).astype(np.float32), 15.0, 0.25),
    "single precision": (ROUND.astype(np.float32), 0.015, 1e-4),
    "millimetres": (ROUND * 1e3, 15.0, 1e-6),
    "turned over": (ROUND * [1, 1, -1], 0.015, 1e-6),
    "half of it": (ROUND[GRID[:, 0] > 0], 0.015, 1e-6),
    "noisy": (NOISY, 0.015, 0.05),
}
WRONG: dict[str, dict[str, Any]] = {
    "five points of two numbers": {"points": np.zeros((5, 2))},
    "nine numbers": {"points": np.zeros(9)},
    "rays of other points": {"points": ROUND, "rays": np.zeros((3, 3))},
    "rays without direction": {"points": ROUND, "rays": np.zeros_like(ROUND)},
    "no noise": {"points": ROUND, "noise": 0.0},
    "noise NaN": {"points": ROUND, "noise": float("nan")},
}


def _is_sphere(radius: float, within: float, concave: bool) -> Check:
    def check(fit: Any) -> bool:
        stated = np.isfinite([fit.radius_sd, fit.curvature_sd, *fit.center, *fit.center_sd]).all()
        return bool(abs(fit.radius / radius - 1) <= within and (fit.curvature < 0) == concave and stated)

    return Check(f"radius {radius:g} within {within:g} of it, deviations finite", check)


def _fitted(arguments: dict[str, Any]) -> Any:
    return fit_sphere(**arguments)


def _off_with_outliers(below: float) -> tuple[float, float]:
    """Return by how many deviations a curvature is off at most, and its deviation over it, where a third of the points fly."""
    rng, worst, stated = np.random.default_rng(3), 0.0, 0.0
    for _ in range(5):
        points = ROUND + np.column_stack([0 * NOISE, 0 * NOISE, rng.normal(0, 0.02e-3, len(GRID))])
        hit = rng.random(len(points)) < 0.33
        side = np.where(rng.random(hit.sum()) < 0.5, -below or 1.0, 1.0)
        points[hit, 2] += rng.uniform(1e-3, 20e-3, hit.sum()) * side
        fit = fit_sphere(points)
        worst = max(worst, abs(fit.curvature - 1 / 0.015) / fit.curvature_sd)
        stated = max(stated, fit.curvature_sd * 0.015)
    return worst, stated


def _plane_deviations() -> list[float]:
    """Return stated deviations of offset and normal of a plane beside the origin over the deviations of 300 draws."""
    rng, plane = np.random.default_rng(0), _with_height(0.1 * GRID[:, 0] - 0.2 * GRID[:, 1]) + [0.02, 0.01, 0.05]
    draws = [np.column_stack([0 * NOISE, 0 * NOISE, rng.normal(0, 1e-4, len(GRID))]) for _ in range(300)]
    fits = [fit_plane(plane + drawn, noise=1e-4) for drawn in draws]
    spread = [np.std([f.offset for f in fits]), *np.std([f.normal for f in fits], axis=0)]
    return [float(v) for v in np.array([fits[0].offset_sd, *fits[0].normal_sd]) / spread]


def _of_duplicates() -> float:
    """Return the deviation by points given four times over the deviation by the same points once."""
    return fit_sphere(np.vstack([NOISY] * 4)).curvature_sd / fit_sphere(NOISY).curvature_sd


def _mixture(below: int, above: int, to: float = 10.0) -> list[float]:
    """Return noise and outliers on each side, over the inliers, that a mixture of 4000 inliers finds, all over the true ones."""
    rng = np.random.default_rng(1)
    outliers = rng.uniform(0.0, to, below + above) * np.repeat([-1.0, 1.0], [below, above])
    residuals = 1e-5 * np.concatenate([rng.normal(0.0, 1.0, 4000), outliers])
    found = Inliers.first(residuals, 4, 1e-9)
    for _ in range(30):
        found = found.next(residuals, found.weights(residuals), 4, 1e-9)
    true = np.maximum([below, above], 1) / 4000 / (to * 1e-5)
    return [found.scale / 1e-5, *(np.array([found.below, found.above]) / true)]


CASES: tuple[Hard, ...] = (
    *group(
        "a sphere stays the same under holes, doubles, distance, precision, units and noise",
        {
            name: (partial(fit_sphere, points), _is_sphere(radius, within, name == "turned over"))
            for name, (points, radius, within) in FOUND.items()
        },
        {
            "a third of the points elsewhere": (
                partial(_off_with_outliers, 1.0),
                Check("curvature within 4 deviations, which is below 5 %", lambda f: f[0] < 4 and f[1] < 0.05),
            ),
            "a third of the points above": (
                partial(_off_with_outliers, 0.0),
                Check("curvature within 4 deviations, which is below 5 %", lambda f: f[0] < 4 and f[1] < 0.05),
            ),
            "deviations of a plane": (_plane_deviations, Value([1.0] * 4, abs=0.12)),
        },
        {"doubles are no more evidence": (_of_duplicates, Value(1.0, abs=1e-9))},
        prefix="cap, ",
    ),
    *group(
        "outliers so near that they could be noise, on one side or both, must be counted where they are",
        {
            "above": (partial(_mixture, 0, 1000), Value([1, 0, 1], abs=0.3)),
            "below": (partial(_mixture, 1000, 0), Value([1, 1, 0], abs=0.3)),
            "on both sides": (partial(_mixture, 500, 1500), Value([1, 1, 1], rel=0.15)),
            "few of them near": (partial(_mixture, 500, 500, 40.0), Value([1, 1, 1], rel=0.25)),
        },
        prefix="near outliers, ",
    ),
    *group(
        "a plane, a ring, a line, too few points, and noise that hides the bend",
        {
            name: (partial(fit_sphere, points), Refusal(IllConditioned, said))
            for name, (points, said) in REFUSED.items()
        },
        prefix="cap, ",
    ),
    *group(
        "inputs that are no points, rays or noise",
        {name: (partial(_fitted, arguments), Refusal(InvalidInput)) for name, arguments in WRONG.items()},
        prefix="cap, ",
    ),
)
