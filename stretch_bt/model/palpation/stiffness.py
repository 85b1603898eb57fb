"""Stiffness of an object from the force on it and the height it lost."""

from __future__ import annotations

import math

from stretch_bt.arguments import check_estimates
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.plain_numbers import is_number
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Estimate

__all__ = ["estimate_stiffness"]

_SIGNIFICANT = 3.0


def estimate_stiffness(force: Estimate, deflection: Estimate, together: float = 0.0) -> Estimate:
    """Return the secant stiffness force / deflection, N/m, with its standard deviation.

    The errors of force, N, and deflection, m, whose correlation is `together`, are carried over at first order. It is negative
    where the force follows from the height of the object's top, which lies the higher the less it gave way.

    Raises
    ------
    InvalidInput
        Force or deflection is no Estimate: a number without its standard deviation gives no stiffness with one.
    IllConditioned
        The deflection is not more than three standard deviations above zero, so the ratio has no useful bound.
    """
    check_estimates(force=force, deflection=deflection)
    if not (is_number(together) and -1 <= together <= 1):
        raise InvalidInput(f"together is a correlation, -1 to 1, not {shown(together)[:80]}")
    if force.value < 0:
        raise InvalidInput(f"force must be at least 0 N, not {force.value}")
    if deflection.value <= _SIGNIFICANT * deflection.sd or deflection.value == 0:
        lost, error = (format_quantity(v, KINDS["Length"]) for v in (deflection.value, deflection.sd))
        raise IllConditioned(
            f"the object lost {lost} of height with a standard deviation of {error}: too little to tell"
        )
    stiffness = force.value / deflection.value
    by_drop = stiffness * deflection.sd
    variance = force.sd**2 + by_drop**2 - 2 * together * force.sd * by_drop
    return Estimate(stiffness, math.sqrt(max(variance, 0.0)) / deflection.value)
