"""Splines over the forces of one hand, and what they give at a depth."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.model.force.membrane_hand import PARAMETERS, MembraneHand
from stretch_bt.model.force.membrane_table import SplineAxis, read_table

__all__ = ["ForceGrids", "along", "moved", "slope"]

Array = npt.NDArray[np.float64]

_STEP = 1e-4
_EVEN = 0.01  # m between stretches


@dataclass(frozen=True)
class ForceGrids:
    """Splines over a hand's own forces: (diameters, stretches, depths) of their logarithm, and of its standard deviation."""

    diameter: SplineAxis
    stretch: SplineAxis
    depth: SplineAxis
    level: Array
    spread: Array

    @classmethod
    def of(cls, hand: MembraneHand, conditioned: float, most: float, covariance: Array) -> ForceGrids:
        """Return the splines of a hand up to a stretch, m; `covariance` (6, 6) has its parameters in the order of `PARAMETERS`."""
        diameter, _, depth = read_table().axes
        stretches = _stretches(conditioned, most)
        level = hand.logarithms(stretches, conditioned)
        rates = np.array([_rate(hand, conditioned, name, stretches, level) for name in PARAMETERS])
        variance = np.einsum("aijk,ab,bijk->ijk", rates, covariance, rates)
        return cls(diameter, SplineAxis(stretches), depth, level, np.sqrt(np.maximum(variance, 0.0)))


def _stretches(conditioned: float, most: float) -> Array:
    """Return the stretches of the splines, m: close to each other where softening ends."""
    even = np.linspace(0.0, most, max(round(most / _EVEN), 4) + 1)
    near = conditioned + read_table().pasts
    far = even[np.min(np.abs(even[:, None] - near), axis=1) > _EVEN / 4]
    return np.unique(np.concatenate([far, near[(near > 0) & (near < most)], [0.0, most]]).round(9))


def moved(hand: MembraneHand, name: str) -> tuple[MembraneHand, float]:
    """Return a hand with a little more of one parameter, and how much that is, to take a difference over."""
    value = getattr(hand, name)
    step = _STEP * max(value, 0.1)
    return hand._replace(**{name: value + step}), step


def _rate(hand: MembraneHand, conditioned: float, name: str, stretches: Array, level: Array) -> Array:
    """Return how the logarithm of the force, N, changes with one parameter."""
    other, step = moved(hand, name)
    off = other.logarithms(stretches, conditioned) - level
    rate: Array = (off + math.log(other.tension / hand.tension)) / step
    return rate


def along(axis: SplineAxis, pieces: list[Any], at: float) -> float:
    """Return the value of a curve at the logarithm of a depth; before the first place and past the last it is a straight line."""
    places = axis.places
    k = min(max(bisect_right(places, at) - 1, 0), len(places) - 2)
    if at < places[0] or at > places[-1]:
        end = 0 if at < places[0] else -1
        value: float = pieces[-1][end] + slope(axis, pieces, places[end]) * (at - places[end])
        return value
    a, b, c, d = pieces[k]
    t = at - places[k]
    found: float = ((a * t + b) * t + c) * t + d
    return found


def slope(axis: SplineAxis, pieces: list[Any], at: float) -> float:
    """Return the slope of a curve at the logarithm of a depth."""
    k = min(max(bisect_right(axis.places, at) - 1, 0), len(axis.places) - 2)
    a, b, c, _ = pieces[k]
    t = at - axis.places[k]
    found: float = (3 * a * t + 2 * b) * t + c
    return found
