"""The choice between shapes by their evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoAnswer
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.fit import INSIDE, OUTSIDE, Fit, fit_to
from stretch_bt.perception.size.hypothesis import Context, Hypothesis, hypothesis
from stretch_bt.perception.size.start import Start
from stretch_bt.perception.types import MaskArray

__all__ = ["Choice", "best_fit", "choose"]

Array = npt.NDArray[np.float64]
CLEARLY = 7.0  # least lead in log evidence, odds of 1000 to 1, of a shape over an earlier, simpler one
# bonus in log evidence of the simplest shape where the stated error counts that another shape may be right: with 3.5, ovals and blocks whose
# outline smooth noise hides were up to 5 deviations off
BELIEF = 1.0
TRIES = 4  # starts, those that leave least


@dataclass(frozen=True, slots=True)
class Choice:
    """The shape that was chosen and its fit; the log evidence of every shape against the best; and its rivals.

    `rivals` are the other shapes with their fits and probabilities: the choice may be wrong, and its size with it. `held_back` is one that
    only its handicap makes less likely than the choice.
    """

    shape: Hypothesis
    fit: Fit
    evidence: dict[str, float]
    rivals: tuple[tuple[Hypothesis, Fit, float], ...]
    held_back: tuple[Hypothesis, Fit] | None


def best_fit(
    shape: Hypothesis, cells: HeightCells, start: Start, *, noise: float = 0.0, window: MaskArray | None = None
) -> Fit:
    """Return the fit of a shape from the start that leaves least, or from the next ones where it is not likely.

    Raises
    ------
    IllConditioned
        No start leads to a fit.
    """
    found: list[Fit] = []
    reason: NoAnswer | None = None
    for q in _ranked(shape, cells, start)[:TRIES]:
        try:
            fit = fit_to(shape, cells, q, noise=noise, window=window)
        except NoAnswer as error:
            reason = error
            continue
        found.append(fit)
        if shape.satisfied(fit.q):
            break
    if not found:
        raise reason or IllConditioned(f"no {shape.name} fits the contact")
    return min(found, key=lambda fit: fit.noise**2 * fit.area)


def _ranked(shape: Hypothesis, cells: HeightCells, start: Start) -> list[Array]:
    """Return the starts of a shape, the one first that leaves least around its own rim, in every fourth cell."""
    starts = shape.starts(start)
    valid = cells.valid[::2, ::2]
    x, y, height = (image[::2, ::2][valid] for image in (cells.x, cells.y, cells.height))
    left = []
    for q in starts:
        outside = shape.outside(q, x, y)
        near = (outside > -INSIDE) & (outside < OUTSIDE)
        residuals = height[near] - shape.model(q, x[near], y[near])[0]
        left.append(float(np.mean(residuals**2)) if near.any() else math.inf)
    return [starts[n] for n in np.argsort(left)]


def choose(names: Sequence[str], cells: HeightCells, start: Start, context: Context, *, noise: float = 0.0) -> Choice:
    """Fit several shapes and return the best, or the first that fits unless the best is clearly better, with all log evidences.

    The evidence is Laplace's approximation (MacKay, Information Theory, chapter 28), for all shapes over the cells around
    the first one's rim and with the noise of the shape that leaves least. `names` are ordered from simple to complex.

    Raises
    ------
    IllConditioned
        No shape fits.
    """
    fits: dict[str, tuple[Hypothesis, Fit]] = {}
    window: MaskArray | None = None
    reason: NoAnswer | None = None
    for name in names:
        shape = hypothesis(name, context)
        try:
            fits[name] = shape, best_fit(shape, cells, start, noise=noise, window=window)
        except NoAnswer as error:
            reason = reason or error
            continue
        window = fits[name][1].window
    if not fits:
        raise reason or IllConditioned("no shape was given to fit")
    quietest = min((fit for _, fit in fits.values()), key=lambda fit: fit.noise**2 * fit.area)
    logs = {name: _log_evidence(shape, fit, quietest) for name, (shape, fit) in fits.items()}
    must = 0.5 * quietest.window.sum() * (start.top / quietest.noise) ** 2 / quietest.area
    scores = {name: value - must * fits[name][0].handicap ** 2 for name, value in logs.items()}
    first, best = next(iter(logs)), max(scores, key=lambda name: scores[name])
    chosen = best if scores[best] > scores[first] + CLEARLY else first
    shape, fit = fits[chosen]
    if chosen != first:
        fit = fit_to(shape, cells, fit.q, noise=noise)
    evidence = {name: float(score - scores[best]) for name, score in scores.items()}
    back = [name for name in fits if fits[name][0].handicap and name != chosen and logs[name] > logs[chosen] - CLEARLY]
    return Choice(shape, fit, evidence, _rivals(fits, evidence, first, chosen), fits[back[0]] if back else None)


def _rivals(
    fits: Mapping[str, tuple[Hypothesis, Fit]], evidence: Mapping[str, float], first: str, chosen: str
) -> tuple[tuple[Hypothesis, Fit, float], ...]:
    """Return the shapes that were not chosen, with their fits and how probable they are."""
    likely = {name: math.exp(value + BELIEF * (name == first)) for name, value in evidence.items()}
    total = sum(likely.values())
    return tuple((*fits[name], value / total) for name, value in likely.items() if name != chosen)


def _log_evidence(shape: Hypothesis, fit: Fit, quietest: Fit) -> float:
    """Return the logarithm of the evidence up to a constant that all shapes share."""
    share = fit.residuals[fit.window] / (3.0 * quietest.noise)
    # a Cauchy-like loss with the curvature of the squares, which the weights of the fit stand for
    misfit = 9.0 / 0.3 * float(np.log1p(0.3 * share * share).sum()) / quietest.area
    _, log_det = np.linalg.slogdet(fit.covariance)
    return -0.5 * misfit + shape.log_prior(fit.q) + 0.5 * float(log_det) + 0.5 * fit.q.size * math.log(2.0 * math.pi)
