"""Fits of a body with the membrane that it presses up, weighted by the covariance of the noise, and their evidence."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from stretch_bt.perception.shapes.contact_cells import Cells, Window
from stretch_bt.perception.shapes.contact_noise import Whiten
from stretch_bt.perception.shapes.fit_steps_kernel import damped_step, fill_left, fill_left_jacobian
from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, SPHERE, PressedSurface, prior_of

__all__ = ["BodyFit", "fit_bodies", "starts", "starts_around"]

Array = npt.NDArray[np.float64]
T = TypeVar("T")
Asking = Generator[Array, Array, T]  # yields rows (m, n) and is sent them whitened

SIZES = np.geomspace(0.1, 0.95, 8)  # sizes of the rim along i that are tried, over the window's
RATIOS = (0.0, 0.6, 1.2)  # halves of the logarithm of the tensions' ratio: the rim is longer along i by as much
LONGER = 0.25  # difference of the logarithms of a rim's semi-axes from their mean, over such a number
UNIT = 0.02  # value of the parameter that a shape is linear in, to see its form
AROUND = np.geomspace(0.4, 2.2, 8)  # sizes of rims that are tried, over another surface's
APART = 0.25  # least difference of two starts, in the logarithm of size or ratio
MOST = (0.8, 1.5, 1.2)  # curvature times size, kink over size, steepness of a cone, to start from
COLUMNS = 8  # that LAPACK solves for at once: a few left over take as long as twice as many
DAMPED = (1e-3, 1e-7, 6)  # of the diagonal, first and least, and how often it is raised


@dataclass(frozen=True, slots=True)
class BodyFit:
    """A fitted surface with the covariance (p, p) of its parameters and its residuals (n,) along the rays, in the cells' unit.

    `misfit` is the sum of the squares of the whitened residuals, `evidence` the logarithm of the surface's evidence, by Laplace's
    approximation, without terms that are the same for all.
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
    """Return at most so many starts of a kind, best first: rims as a surface has and others of some forms, larger or smaller."""
    own = surface.q[4:9]
    mean = 0.5 * (own[0] + own[1])
    forms = [own] + [np.array([mean + LONGER * r, mean - LONGER * r, own[2], own[3], r]) for r in RATIOS]
    larger = np.array([1.0, 1.0, 0.0, 0.0, 0.0])
    rims = [form + larger * math.log(share) for form in forms for share in AROUND]
    return _best_of(rims, cells, kind, whiten, most)


def _best_of(rims: list[Array], cells: Cells, kind: int, whiten: Whiten, most: int) -> list[PressedSurface]:
    chosen: list[PressedSurface] = []
    for _, surface in sorted(_tried(rims, cells, kind, whiten), key=lambda pair: pair[0]):
        if all(_apart(surface.q, other.q) > APART for other in chosen):
            chosen.append(surface)
        if len(chosen) == most:
            break
    return chosen


def _apart(q: Array, other: Array) -> float:
    """Return the larger difference of two rims, in the logarithm of size or ratio."""
    return max(abs(float(q[4] - other[4])), abs(float(q[8] - other[8])))


def _tried(rims: list[Array], cells: Cells, kind: int, whiten: Whiten) -> list[tuple[float, PressedSurface]]:
    """Return the squared residuals of the cells to rims, each with the best amount of its form, and the surfaces, without any that is no bump.

    Least squares by a plane and a form: the residuals of all forms to the plane are computed at once.
    """
    bodies = _unit_forms(rims, cells, kind)
    forms = [body.heights(cells.x, cells.y) / UNIT for body in bodies]
    columns = whiten(np.stack([np.ones_like(cells.x), cells.x, cells.y, cells.z, *forms]).T)
    gram = columns.T @ columns
    try:
        planes = np.linalg.solve(gram[:3, :3], gram[:3, 3:])
    except np.linalg.LinAlgError:
        return []
    left, found = gram[3:, 3:] - gram[3:, :3] @ planes, []
    for n, body in enumerate(bodies, start=1):
        if left[n, n] > 0.0 and left[0, n] > 0.0:
            amount = float(left[0, n] / left[n, n])
            surface = _with_amount(body, amount, planes[:, 0] - amount * planes[:, n])
            found.append((float(left[0, 0] - amount * left[0, n]), surface))
    return found


def _unit_forms(rims: list[Array], cells: Cells, kind: int) -> list[PressedSurface]:
    """Return bodies on rims that are form alone: UNIT of the parameter that a kind is linear in, without a plane and without bends of the skirt."""
    first = prior_of(kind, cells.size)[0]
    first[9:COMMON] = 0.0
    first[_amount_at(kind)] = UNIT
    bodies = []
    for rim in rims:
        q = first.copy()
        q[4:9] = rim
        bodies.append(PressedSurface(kind, q))
    return bodies


def _amount_at(kind: int) -> int:
    return COMMON if kind == FACE else 3


def _with_amount(body: PressedSurface, amount: float, plane: Array) -> PressedSurface:
    """Return a body of a form with so much of it, over a plane (3,)."""
    kind, q = body.kind, body.q.copy()
    a, b, x0, y0 = math.exp(q[4]), math.exp(q[5]), q[6], q[7]
    q[_amount_at(kind)] = min(
        amount, MOST[0] / max(a, b) if kind == SPHERE else MOST[1] * a if kind == FACE else MOST[2]
    )
    q[:3] = plane
    if kind == CONE:  # about its tip, the others about the middle of the window
        q[0] += plane[1] * x0 + plane[2] * y0
    if kind == SPHERE:
        q[0] -= 0.5 * q[3] * (x0 * x0 + y0 * y0)
        q[1] += q[3] * x0
        q[2] += q[3] * y0
    return PressedSurface(kind, q)


@dataclass(frozen=True, slots=True)
class _Prior:
    """Means and weights (p,), over the variance, of the parameters."""

    mean: Array
    weight: Array


@dataclass(frozen=True, slots=True)
class _Tried:
    """A surface with its residuals (n,), the same whitened, and the cost of both it and them."""

    surface: PressedSurface
    left: Array
    errors: Array
    cost: float


def fit_bodies(
    surfaces: Sequence[PressedSurface], cells: Cells, whiten: Whiten, *, steps: int, close: float
) -> list[BodyFit]:
    """Return the most probable surface near each start, by damped Gauss-Newton, until a step gains less than `close`.

    They go on side by side, so that all rows that they ask for are whitened at once: one pass over the noise's covariance, which is as
    large as the processor's cache, serves them all.
    """
    fits = [_fitted(surface, cells, steps, close) for surface in surfaces]
    found: dict[int, BodyFit] = {}
    asked = {n: next(fit) for n, fit in enumerate(fits)}
    while asked:
        errors, first = _whitened(list(asked.values()), whiten), 0
        for n, rows in list(asked.items()):
            first, own = first + len(rows), errors[first : first + len(rows)]
            try:
                asked[n] = fits[n].send(own)
            except StopIteration as end:
                found[n] = end.value
                del asked[n]
    return [found[n] for n in range(len(fits))]


def _whitened(asked: list[Array], whiten: Whiten) -> Array:
    """Return rows (m, n) of all that is asked, whitened, and more rows of nothing up to a number that is solved for at once."""
    count = sum(len(rows) for rows in asked)
    spare = -count % COLUMNS if count > 1 else 0
    return whiten(np.concatenate([*asked, np.zeros((spare, asked[0].shape[1]))]).T).T


def _fitted(surface: PressedSurface, cells: Cells, steps: int, close: float) -> Asking[BodyFit]:
    """Fit one surface, as `fit_bodies` does: it asks for rows (m, n) to be whitened."""
    mean, sd = prior_of(surface.kind, cells.size)
    prior, damping = _Prior(mean, sd**-2.0), DAMPED[0]
    at = yield from _trial(surface, cells, _left(surface, cells, np.zeros_like(cells.z)), prior)
    normal, slope = yield from _normal(at, cells, prior)
    for _ in range(steps):
        moved, damping = yield from _stepped(at, normal, slope, damping, cells, prior)
        if moved is None:
            break
        gain, at = at.cost - moved.cost, moved
        normal, slope = yield from _normal(at, cells, prior)
        if gain < close:
            break
    evidence = -0.5 * at.cost - 0.5 * float(np.linalg.slogdet(normal)[1]) - float(np.log(sd).sum())
    misfit = float(at.errors @ at.errors)
    return BodyFit(at.surface, np.asarray(np.linalg.inv(normal), float), at.left, misfit, evidence)


def _stepped(
    at: _Tried, normal: Array, slope: Array, damping: float, cells: Cells, prior: _Prior
) -> Asking[tuple[_Tried | None, float]]:
    """Return the surface after a step that costs no more, None where there is none, and the damping for the next."""
    for _ in range(DAMPED[2]):
        q = np.empty_like(slope)
        if damped_step(at.surface.q, normal, slope, damping, q):
            moved = yield from _trial(PressedSurface(at.surface.kind, q), cells, at.left, prior)
            if moved.cost <= at.cost:
                return moved, max(0.1 * damping, DAMPED[1])
        damping = 10.0 * max(damping, 1e-4)
    return None, damping


def _trial(surface: PressedSurface, cells: Cells, before: Array, prior: _Prior) -> Asking[_Tried]:
    """Return a surface with the residuals of the cells to it, and its cost."""
    left, off = _left(surface, cells, before), surface.q - prior.mean
    errors = (yield left[None])[0]
    cost = float(errors @ errors + (off * off) @ prior.weight)
    return _Tried(surface, left, errors, cost if math.isfinite(cost) else math.inf)


def _left(surface: PressedSurface, cells: Cells, before: Array) -> Array:
    """Return the residuals of the cells to a surface, each where its own ray meets it, as far as `before` says where."""
    left = np.empty_like(cells.z)
    fill_left(surface.kind, surface.q, cells.x, cells.y, cells.z, cells.lean, before, left)
    return left


def _normal(at: _Tried, cells: Cells, prior: _Prior) -> Asking[tuple[Array, Array]]:
    """Return the matrix (p, p) and the right side (p,) of the normal equations."""
    q, jacobian = at.surface.q, np.empty((at.surface.q.size, cells.z.size))
    fill_left_jacobian(at.surface.kind, q, cells.x, cells.y, cells.lean, at.left, jacobian)
    by = yield jacobian
    normal = by @ by.T
    normal.reshape(-1)[:: q.size + 1] += prior.weight
    return normal, by @ at.errors - (q - prior.mean) * prior.weight
