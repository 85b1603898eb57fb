"""Figures of a sensitivity map: mean errors, where they are below a millimetre, and their trends with depth, stretch and diameter."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.model.calibration.protocol import State
from stretch_bt.model.calibration.sensitivity import Sensed
from stretch_bt.units import Estimate

__all__ = ["ALONG", "FINE", "ErrorBin", "Trend", "cells_of", "depth_from", "fine_share", "mean_error", "trend"]

FINE = 1e-3  # m: an error below this is sub-millimetre
_GRID = {
    "size": 1e-4,
    "stretch": 1e-3,
    "depth": 5e-4,
}  # m; steps to which measured places are rounded, so that equal ones match
ALONG = ("depth", "stretch", "size")


@dataclass(frozen=True, slots=True)
class ErrorBin:
    """A diameter, stretch and depth, m: mean errors along i and j and their mean absolute error over the presses that were not refused.

    The errors are None where all `refused` of the `presses` were.
    """

    size: float
    stretch: float
    depth: float
    presses: int
    refused: int
    i: float | None
    j: float | None
    absolute: float | None

    @property
    def fine(self) -> bool:
        """Whether no press was refused, and the mean absolute error is below a millimetre."""
        return self.absolute is not None and not self.refused and self.absolute < FINE


@dataclass(frozen=True, slots=True)
class Trend:
    """How the absolute error goes with one quantity where the others stay: over `groups` of presses that share those.

    `rank` is the mean of Spearman's rank correlations of the groups, a refusal counting as the largest error; `slope`, m of
    error a m, the mean of their slopes over presses that were not refused, None where no group has two. Where one group alone
    says something, each is a bare number: its error is not known.
    """

    along: str
    groups: int
    rank: Estimate | float
    slope: Estimate | float | None


def cells_of(presses: Iterable[Sensed], method: str) -> list[ErrorBin]:
    """Return the map of a method, in the order of diameter, stretch and depth."""
    grouped: dict[tuple[float, ...], list[Sensed]] = defaultdict(list)
    for press in presses:
        grouped[tuple(_rounded(press, name) for name in ("size", "stretch", "depth"))].append(press)
    return [_cell(place, group, method) for place, group in sorted(grouped.items())]


def depth_from(presses: Sequence[Sensed], least_depth: float) -> float:
    """Return the depth, m, from which on presses count in a mean error: `least_depth`, or where none is so deep the largest depth."""
    return min(least_depth, max((_rounded(press, "depth") for press in presses), default=0.0))


def mean_error(presses: Sequence[Sensed], method: str, least_depth: float = 0.0) -> Estimate:
    """Return the mean absolute error of diameters along i and j, m, with its standard error; of one press, its own error.

    It is over presses from `depth_from` on; refused presses do not count.

    Raises
    ------
    IllConditioned
        The method refused all of these, or there are none.
    """
    least = depth_from(presses, least_depth) - 1e-9
    chosen = [press for press in presses if _rounded(press, "depth") >= least]
    found = [_absolute(errors) for press in chosen if (errors := press.of(method).errors(press.size)) is not None]
    if not found:
        raise IllConditioned(
            f"'{method}' measured none of {len(chosen)} presses, so that it has no mean error; the table says why"
        )
    spread = float(np.std(found, ddof=1)) if len(found) > 1 else found[0]
    return Estimate(float(np.mean(found)), spread / math.sqrt(len(found)))


def fine_share(cells: Sequence[ErrorBin]) -> Estimate:
    """Return the share of a map that is measured to below a millimetre, with its binomial standard deviation.

    Raises
    ------
    IllConditioned
        The map is empty.
    """
    if not cells:
        raise IllConditioned("a map without presses has no share")
    share = sum(cell.fine for cell in cells) / len(cells)
    # by Agresti and Coull (1998), which has a width at 0 and 1 as well
    drawn = (sum(cell.fine for cell in cells) + 2) / (len(cells) + 4)
    return Estimate(share, math.sqrt(drawn * (1 - drawn) / (len(cells) + 4)))


def trend(cells: Sequence[ErrorBin], along: str) -> Trend:
    """Return how the absolute error goes with `depth`, `stretch` or `size` at fixed others.

    Raises
    ------
    IllConditioned
        Nowhere do two places of the map differ in it alone, or by errors that differ.
    """
    others = [name for name in ALONG if name != along]
    grouped: dict[tuple[float, ...], list[ErrorBin]] = defaultdict(list)
    for cell in cells:
        grouped[tuple(getattr(cell, name) for name in others)].append(cell)
    ranks = _told(_rank(group, along) for group in grouped.values())
    if not ranks:
        raise IllConditioned(f"no two presses of the map differ in {along} alone")
    slopes = _told(_slope(group, along) for group in grouped.values())
    return Trend(along, len(ranks), _mean(ranks), _mean(slopes) if slopes else None)


def _cell(place: tuple[float, ...], group: list[Sensed], method: str) -> ErrorBin:
    told = [errors for press in group if (errors := press.of(method).errors(press.size)) is not None]
    size, stretch, depth = place
    if not told:
        return ErrorBin(size, stretch, depth, len(group), len(group), None, None, None)
    # rounded, so that errors that are alike have one rank
    i, j = (round(float(v), 9) for v in np.mean(told, axis=0))
    absolute = round(float(np.mean([_absolute(errors) for errors in told])), 9)
    return ErrorBin(size, stretch, depth, len(group), len(group) - len(told), i, j, absolute)


def _rounded(press: State, name: str) -> float:
    step = _GRID[name]
    return round(round(float(getattr(press, name)) / step) * step, 9)


def _absolute(errors: tuple[float, float]) -> float:
    return (abs(errors[0]) + abs(errors[1])) / 2


def _told(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _rank(group: list[ErrorBin], along: str) -> float | None:
    from scipy.stats import rankdata

    errors = rankdata([math.inf if cell.absolute is None else cell.absolute for cell in group])
    places = rankdata([getattr(cell, along) for cell in group])
    if np.ptp(errors) == 0 or np.ptp(places) == 0:
        return None
    return float(np.corrcoef(places, errors)[0, 1])


def _slope(group: list[ErrorBin], along: str) -> float | None:
    known = [(float(getattr(cell, along)), cell.absolute) for cell in group if cell.absolute is not None]
    places, errors = np.array(known, dtype=float).reshape(-1, 2).T
    if len(known) < 2 or np.ptp(places) == 0:
        return None
    off = places - places.mean()
    return float(off @ errors / (off @ off))


def _mean(values: Sequence[float]) -> Estimate | float:
    """Return a mean with its standard error, or one value as it is."""
    if len(values) == 1:
        return values[0]
    return Estimate(float(np.mean(values)), float(np.std(values, ddof=1)) / math.sqrt(len(values)))
