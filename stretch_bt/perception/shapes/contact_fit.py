"""Fits of a body with the membrane that it presses up, weighted by the covariance of the noise, and their evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.contact_cells import Cells, Window
from stretch_bt.perception.shapes.contact_noise import Whiten
from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, SPHERE, PressedSurface, prior_of

__all__ = ["BodyFit", "fit_body", "starts", "starts_around"]

Array = npt.NDArray[np.float64]

SIZES = np.geomspace(0.1, 0.95, 8)  # of the rim along i, over the window's, that are tried
RATIOS = (0.0, 0.6, 1.2)  # halves of the logarithm of the tensions' ratio, by which the rim is longer along i
LONGER = 0.25  # of a ratio, by which the logarithms of a rim's semi-axes differ from their mean
UNIT = 0.02  # of what a shape is linear in, to see its form
AROUND = np.geomspace(0.4, 2.2, 8)  # sizes of rims, over that of another surface, that are tried
APART = 0.25  # of the logarithms of size and ratio, by which another start is another one
MOST = (0.8, 1.5, 1.2)  # curvature times size, kink over size, steepness of a cone, to start from
DAMPED = (1e-3, 1e-7, 6)  # of the diagonal, first and least, and how often it is raised


@dataclass(frozen=True, slots=True)
class BodyFit:
    """A fitted surface with the covariance (p, p) of its parameters and its residuals (n,) along the rays, in the cells' unit.

    `misfit` is the sum of the squares of the whitened residuals, `evidence` the logarithm of that of the surface, by Laplace's
    approximation, but for what is the same for all.
    """

    surface: PressedSurface
    covariance: Array
    residuals: Array
    misfit: float
    evidence: float


def starts(cells: Cells, window: Window, kind: int, whiten: Whiten) -> list[PressedSurface]:
    """Return the best start of a kind: rims of several sizes and forms are tried, each with the best amount of its form."""
    x, y = (window.top[0] - window.x) / cells.size, (window.top[1] - window.y) / cells.size
    rims = []
    for ratio in RATIOS:
        for share in SIZES:
            a = float(share) * window.a / cells.size
            b = min(a * math.exp(-ratio), 0.95 * window.b / cells.size)
            rims.append(np.array([math.log(a), math.log(b), x, y, ratio]))
    return _best_of(rims, cells, kind, whiten, 1)


def starts_around(surface: PressedSurface, cells: Cells, kind: int, whiten: Whiten, most: int) -> list[PressedSurface]:
    """Return at most so many starts of a kind, best first: rims as that of a surface and round ones, greater or smaller."""
    own = surface.q[4:9]
    mean = 0.5 * (own[0] + own[1])
    forms = [own] + [np.array([mean + LONGER * r, mean - LONGER * r, own[2], own[3], r]) for r in RATIOS]
    larger = np.array([1.0, 1.0, 0.0, 0.0, 0.0])
    rims = [form + larger * math.log(share) for form in forms for share in AROUND]
    return _best_of(rims, cells, kind, whiten, most)


def _best_of(rims: list[Array], cells: Cells, kind: int, whiten: Whiten, most: int) -> list[PressedSurface]:
    found = [pair for rim in rims if (pair := _tried(rim, cells, kind, whiten)) is not None]
    found.sort(key=lambda pair: pair[0])
    chosen: list[PressedSurface] = []
    for _, surface in found:
        if all(np.abs(surface.q[[4, 8]] - other.q[[4, 8]]).max() > APART for other in chosen):
            chosen.append(surface)
    return chosen[:most]


def _tried(rim: Array, cells: Cells, kind: int, whiten: Whiten) -> tuple[float, PressedSurface] | None:
    """Return what a rim leaves of the cells, with the best amount of its form, and that surface; None where it is no bump."""
    q = prior_of(kind, cells.size)[0]
    q[4:9], q[9:COMMON] = rim, 0.0
    a, b, x0, y0 = math.exp(q[4]), math.exp(q[5]), q[6], q[7]
    at = COMMON if kind == FACE else 3
    q[at] = UNIT
    form = PressedSurface(kind, q).heights(cells.x, cells.y) / UNIT
    design = np.stack([np.ones_like(form), cells.x - x0, cells.y - y0, form, cells.z], axis=1)
    weighted = whiten(design)
    normal = weighted.T @ weighted
    try:
        solution = np.linalg.solve(normal[:4, :4], normal[:4, 4])
    except np.linalg.LinAlgError:
        return None
    level, p1, p2, amount = solution.tolist()
    if amount <= 0.0:
        return None
    q[at] = min(amount, MOST[0] / max(a, b) if kind == SPHERE else MOST[1] * a if kind == FACE else MOST[2])
    q[:3] = level, p1, p2
    if kind != CONE:
        q[0] -= p1 * x0 + p2 * y0
    if kind == SPHERE:  # about the middle of the window, not of the rim
        q[0] -= 0.5 * q[3] * (x0 * x0 + y0 * y0)
        q[1] += q[3] * x0
        q[2] += q[3] * y0
    return float(normal[4, 4] - solution @ normal[:4, 4]), PressedSurface(kind, q)


def fit_body(surface: PressedSurface, cells: Cells, whiten: Whiten, *, steps: int, close: float) -> BodyFit:
    """Return the most probable surface near a start, by damped Gauss-Newton, until a step gains less than `close`."""
    mean, sd = prior_of(surface.kind, cells.size)
    weight = sd**-2.0
    left = _left(surface, cells, _left(surface, cells, np.zeros_like(cells.z)))
    cost, damping = _cost(surface, left, whiten, mean, weight), DAMPED[0]
    for _ in range(steps):
        normal, slope = _normal(surface, cells, left, whiten, mean, weight)
        for _ in range(DAMPED[2]):
            step = np.asarray(np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope), float)
            moved = surface.moved(step)
            moved_left = _left(moved, cells, left)
            moved_cost = _cost(moved, moved_left, whiten, mean, weight)
            if moved_cost <= cost:
                break
            damping = 10.0 * max(damping, 1e-4)
        else:
            break
        gain, surface, left, cost = cost - moved_cost, moved, moved_left, moved_cost
        damping = max(0.1 * damping, DAMPED[1])
        if gain < close:
            break
    normal, _ = _normal(surface, cells, left, whiten, mean, weight)
    evidence = -0.5 * cost - 0.5 * float(np.linalg.slogdet(normal)[1]) - float(np.log(sd).sum())
    misfit = float(np.sum(whiten(left) ** 2))
    return BodyFit(surface, np.asarray(np.linalg.inv(normal), float), left, misfit, evidence)


def _left(surface: PressedSurface, cells: Cells, before: Array) -> Array:
    """Return what the cells are above a surface, each where its own ray meets it, as far as `before` says where."""
    return np.asarray(cells.z - surface.heights(cells.x - cells.lean[0] * before, cells.y - cells.lean[1] * before))


def _cost(surface: PressedSurface, left: Array, whiten: Whiten, mean: Array, weight: Array) -> float:
    cost = float(np.sum(whiten(left) ** 2) + np.sum((surface.q - mean) ** 2 * weight))
    return cost if math.isfinite(cost) else math.inf


def _normal(
    surface: PressedSurface, cells: Cells, left: Array, whiten: Whiten, mean: Array, weight: Array
) -> tuple[Array, Array]:
    """Return the matrix (p, p) and the right side (p,) of the normal equations."""
    _, jacobian = surface.derivatives(cells.x - cells.lean[0] * left, cells.y - cells.lean[1] * left)
    both = whiten(np.concatenate([jacobian, left[None]]).T)
    by, errors = both[:, :-1], both[:, -1]
    return by.T @ by + np.diag(weight), by.T @ errors - (surface.q - mean) * weight
