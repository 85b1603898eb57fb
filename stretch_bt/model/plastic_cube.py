"""Yield stress of a plastic cube from the force that presses it flat."""

from __future__ import annotations

import math
from typing import Final

from stretch_bt.arguments import check_estimates, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.units import Estimate

__all__ = ["cube_yield_stress"]

_GRAVITY: Final = 9.81  # m/s^2
_PRESSURE: Final = 1.45  # mean pressure on a cube that sticks to what presses it, over its yield stress
#: its relative standard deviation: a cube that slides bears some 1.3, one pressed by a fifth 1.5
_SCATTER: Final = 0.03
_SIGNIFICANT: Final = 2.0
_SHORTEST, _LONGEST, _STRONGEST, _DENSEST = 1e-6, 1e3, 1e9, 1e6


def cube_yield_stress(force: Estimate, edge: Estimate, *, density: float = 1250.0) -> Estimate:
    """Return the yield stress, Pa, of a cube of edge `edge`, m, whose top flows under `force`, N.

    A cube of density `density`, kg/m^3, that lost a twentieth to a sixth of its height between two plates to which it sticks
    bears 1.45 times its yield stress (Avitzur 1968: 1 + 2 a / (3 sqrt3 h), and what the edges add), its own weight among it:
    Y = (F + density g edge^3) / (1.45 edge^2). The press must have passed the elastic range: there the force rises with the
    depth, while a cube that flows keeps it. Errors are carried over at first order; the pressure's own is 3 %.

    Raises
    ------
    InvalidInput
        A value is not finite or not of this world: edge 1e-6 to 1e3 m, force 0 to 1e9 N, density to 1e6 kg/m^3.
    IllConditioned
        The force or the edge is within two standard deviations of 0.
    """
    check_estimates(force=force, edge=edge)
    check_numbers("", density=density)
    if not _SHORTEST <= edge.value <= _LONGEST or not 0 <= force.value <= _STRONGEST or not 0 < density <= _DENSEST:
        raise InvalidInput(
            f"edge must be {_SHORTEST:g} to {_LONGEST:g} m, force 0 to {_STRONGEST:g} N, density above 0 and at most {_DENSEST:g} kg/m^3"
        )
    if force.value <= _SIGNIFICANT * force.sd or edge.value <= _SIGNIFICANT * edge.sd:
        raise IllConditioned("the force or the edge is too uncertain to determine a yield stress; press harder")
    weight = density * _GRAVITY * edge.value**3
    value = (force.value + weight) / (_PRESSURE * edge.value**2)
    by_force = force.sd / (force.value + weight)
    by_edge = (2 * force.value - weight) / (force.value + weight) * edge.sd / edge.value
    return Estimate(value, value * math.hypot(by_force, by_edge, _SCATTER))
