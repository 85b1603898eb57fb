"""Young's modulus of an elastic sphere from the force on it and how the way was shared with the membrane."""

from __future__ import annotations

import math
from functools import partial

from stretch_bt.arguments import check_estimates, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model.carried import carried
from stretch_bt.units import Estimate

__all__ = ["object_modulus"]

_SIGNIFICANT = 2.0


def object_modulus(
    force: Estimate, deflection: Estimate, depth: Estimate, radius: Estimate, *, poisson: float = 0.5
) -> Estimate:
    """Return Young's modulus, Pa, of a sphere that gave way by `deflection`, m, while the membrane was entered by `depth`, m.

    The paper's formula for an elastic sphere on the membrane, F = 4/3 sqrt(d^3 R) / ((1 - v^2)/E* + (1 - v_o^2)/E_o), with d the
    depth of both together and E* the membrane's modulus at the same force under a rigid sphere, F = 4/3 sqrt(depth^3 R) E* / (1 - v^2),
    gives E_o = (1 - v_o^2) F / (4/3 sqrt(R) (d^1.5 - depth^1.5)). Errors are carried over at first order.

    Raises
    ------
    InvalidInput
        A value is not finite, or a radius is not above 0 m, a force below 0 N, or a Poisson ratio outside -1 to 0.5.
    IllConditioned
        The sphere has not given way by more than two standard deviations, or nothing presses on it.
    """
    given = {"force": force, "deflection": deflection, "depth": depth, "radius": radius}
    check_estimates(**given)
    check_numbers("", poisson=poisson)
    if radius.value <= 0 or force.value < 0 or depth.value < 0 or not -1 < poisson <= 0.5:
        raise InvalidInput(
            "radius must be above 0 m, force and depth at least 0, the Poisson ratio above -1 and at most 0.5"
        )
    if force.value <= _SIGNIFICANT * force.sd or deflection.value <= max(_SIGNIFICANT * deflection.sd, 0.0):
        raise IllConditioned("the object gave way too little, or too little force is on it, to determine its modulus")
    return carried(partial(_modulus, poisson=poisson), *given.values())


def _modulus(force: float, deflection: float, depth: float, radius: float, *, poisson: float) -> float:
    grown = (depth + deflection) ** 1.5 - depth**1.5
    if not grown > 0.0:
        raise IllConditioned("the object gave way by less than a number beside its depth can show; press harder")
    found: float = (1 - poisson**2) * force / (4 / 3 * math.sqrt(radius) * grown)
    return found
