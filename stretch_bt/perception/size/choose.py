"""The choice between shapes by their evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import IllConditioned, NoAnswer
from stretch_bt.perception.size.cells import Cells
from stretch_bt.perception.size.fit import Fit, fit_to
from stretch_bt.perception.size.hypothesis import Context, Hypothesis, hypothesis
from stretch_bt.perception.size.start import Start
from stretch_bt.perception.types import MaskArray

__all__ = ["Choice", "best_fit", "choose"]

Array = npt.NDArray[np.float64]
Choice = tuple[Hypothesis, Fit, dict[str, float]]

CLEARLY = 5.0  # of log evidence by which a shape must beat an earlier, simpler one


def best_fit(shape: Hypothesis, cells: Cells, start: Start, *, noise: float = 0.0, window: MaskArray | None = None) -> Fit:
    """Return the fit of a shape from that of its starts which leaves least; raises IllConditioned where none fits."""
    found: list[Fit] = []
    reason: NoAnswer | None = None
    for q in shape.starts(start):
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


def choose(names: Sequence[str], cells: Cells, start: Start, context: Context, *, noise: float = 0.0) -> Choice:
    """Fit several shapes and return the simplest that no other clearly beats, with the log evidence of each.

    The evidence is Laplace's approximation (MacKay, Information Theory, chapter 28), for all shapes over the same cells
    and with the noise of the one that leaves least. `names` are ordered from simple to complex.

    Raises
    ------
    IllConditioned
        No shape fits.
    """
    fits: dict[str, tuple[Hypothesis, Fit]] = {}
    reason: NoAnswer | None = None
    for name in names:
        shape = hypothesis(name, context)
        try:
            fits[name] = shape, best_fit(shape, cells, start, noise=noise)
        except NoAnswer as error:
            reason = reason or error
    if not fits:
        raise reason or IllConditioned("no shape was given to fit")
    if len(fits) == 1:
        ((name, (shape, fit)),) = fits.items()
        return shape, fit, {name: 0.0}
    window = np.logical_or.reduce([fit.window for _, fit in fits.values()])
    fits = {name: (shape, fit_to(shape, cells, fit.q, window=window, noise=noise)) for name, (shape, fit) in fits.items()}
    quietest = min((fit for _, fit in fits.values()), key=lambda fit: fit.noise**2 * fit.area)
    logs = {name: _log_evidence(shape, fit, quietest) for name, (shape, fit) in fits.items()}
    chosen = names[0] if names[0] in logs else next(iter(logs))
    for name, value in logs.items():
        if value > logs[chosen] + CLEARLY:
            chosen = name
    top = max(logs.values())
    return *fits[chosen], {name: value - top for name, value in logs.items()}


def _log_evidence(shape: Hypothesis, fit: Fit, quietest: Fit) -> float:
    """Return the logarithm of the evidence up to a constant that all shapes share."""
    share = fit.residuals[fit.window] / (3.0 * quietest.noise)
    # a Cauchy-like loss with the curvature of the squares: what the weights of the fit stand for
    misfit = 9.0 / 0.3 * float(np.log1p(0.3 * share * share).sum()) / quietest.area
    _, log_det = np.linalg.slogdet(fit.covariance)
    return -0.5 * misfit + shape.log_prior(fit.q) + 0.5 * float(log_det) + 0.5 * fit.q.size * math.log(2.0 * math.pi)
