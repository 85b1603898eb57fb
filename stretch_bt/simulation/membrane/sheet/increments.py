"""The increments of a press whose end depends on how it is reached."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.spline import Array

__all__ = ["between", "increments"]

_FEWEST = 4  # least number from first contact, so that a shallow press has a path too
_TURN = 0.05  # rad; about a sheet unit at the rim of a usual body


def increments(start: Load | None, load: Load, unit: float) -> Iterator[Load]:
    """Yield loads on a straight line to `load`, from an earlier one or from first contact at the same place.

    Each moves the clamps or the body by at most a sheet unit, `unit` in m, and turns it by at most 0.05 rad.
    """
    least = 1
    if start is None:
        start, least = load.part(0.0), _FEWEST
    change = load.moves() - start.moves()
    count = max(least, math.ceil(float(np.abs(change / _limits(unit)).max()) - 1e-9))
    for k in range(1, count + 1):
        yield load if k == count else _at(load, start.moves() + change * (k / count))


def between(start: Load, load: Load) -> Load:
    """Return the load half way from one to another."""
    return _at(load, (start.moves() + load.moves()) / 2)


def _limits(unit: float) -> Array:
    return np.array([unit, unit, unit, unit, _TURN, _TURN])


def _at(load: Load, moves: Array) -> Load:
    stretch, depth, x, y, a, b = moves.tolist()
    return replace(load, stretch=stretch, depth=depth, at=(x, y), tilt=(a, b))
