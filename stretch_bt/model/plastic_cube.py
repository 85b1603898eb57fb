"""Yield stress of a plastic cube from the force that presses it flat."""

from __future__ import annotations

import math
from functools import partial
from typing import Final

from stretch_bt.arguments import check_estimates, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.carried import carried
from stretch_bt.units import Estimate

__all__ = ["cube_yield_stress"]

_GRAVITY: Final = 9.81  # m/s^2
_PRESSURE: Final = 1.45  # mean pressure on a cube that sticks to what presses it, over its yield stress
_SCATTER: Final = 0.03  # its relative standard deviation; a cube that slides bears up to a fifth less
_FREE: Final = 0.15  # part of the height up to which that pressure counts on the section that the cube had
# of its growth past that, as the section grows, and the doubt about it, as a part of it
_SLOPE, _BEND, _DOUBT = 0.7, 3.8, 0.2
_SPREAD: Final = 0.3  # doubt about the weight, which is spread over the height, as a part of it
_LEAST, _MOST = 0.02, 0.4  # parts of the height between which it is known
_SIGNIFICANT: Final = 2.0
_SHORTEST, _LONGEST, _STRONGEST, _DENSEST = 1e-6, 1e3, 1e9, 1e6


def cube_yield_stress(force: Estimate, edge: Estimate, height: Estimate, *, density: float = 1250.0) -> Estimate:
    """Return the yield stress, Pa, of a cube of edge `edge`, m, that flows under `force`, N, at a height of `height`, m.

    A cube of density `density`, kg/m^3, between two plates to which it sticks bears 1.45 times its yield stress (Avitzur 1968:
    1 + 2 a / (3 sqrt3 h), and what the edges add), its own weight among it: Y = (F + density g edge^3) / (1.45 f edge^2), where
    f is 1 up to a loss of 0.15 of its height, and 1 + 0.7 x + 3.8 x^2 at a loss x more. The press must have passed the elastic
    range: there the force rises with the depth, while a cube that flows keeps it. Errors are carried over at first order; the
    pressure's own is 3 %, a fifth of its growth, and three tenths of the weight.

    Raises
    ------
    InvalidInput
        A value is not finite or not of this world: edge 1e-6 to 1e3 m, force 0 to 1e9 N, density to 1e6 kg/m^3.
    IllConditioned
        The force or the edge is within two standard deviations of 0, or the cube lost less than 0.02 or more than 0.4 of its height.
    """
    check_estimates(force=force, edge=edge, height=height)
    check_numbers("", density=density)
    if not _SHORTEST <= edge.value <= _LONGEST or not 0 <= force.value <= _STRONGEST or not 0 < density <= _DENSEST:
        raise InvalidInput(
            f"edge must be {_SHORTEST:g} to {_LONGEST:g} m, force 0 to {_STRONGEST:g} N, density above 0 and at most {_DENSEST:g} kg/m^3"
        )
    if force.value <= _SIGNIFICANT * force.sd or edge.value <= _SIGNIFICANT * edge.sd:
        raise IllConditioned("the force or the edge is too uncertain to determine a yield stress; press harder")
    lost = 1 - height.value / edge.value
    if not _LEAST <= lost <= _MOST:
        raise IllConditioned(
            f"the cube lost {lost:.2g} of its height, and its yield stress shows between {_LEAST:g} and {_MOST:g}; press it to that"
        )
    found = carried(partial(_stress, density=density), force, edge, height)
    weight = _weight(edge.value, density)
    by_law = math.hypot(_SCATTER, _DOUBT * (_growth(lost) - 1), _SPREAD * weight / (force.value + weight))
    return Estimate(found.value, math.hypot(found.sd, found.value * by_law))


def _stress(force: float, edge: float, height: float, *, density: float) -> float:
    return (force + _weight(edge, density)) / (_PRESSURE * _growth(1 - height / edge) * edge**2)


def _weight(edge: float, density: float) -> float:
    return density * _GRAVITY * edge**3


def _growth(lost: float) -> float:
    more = max(lost - _FREE, 0.0)
    return 1 + _SLOPE * more + _BEND * more**2
