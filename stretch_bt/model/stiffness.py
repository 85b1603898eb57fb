"""Stiffness of an object from the force on it and the height it lost."""

from __future__ import annotations

import math

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.units import KINDS, Estimate, format_quantity

__all__ = ["estimate_stiffness"]

_SIGNIFICANT = 3.0


def estimate_stiffness(force: Estimate, deflection: Estimate) -> Estimate:
    """Return the secant stiffness force / deflection, N/m, with its standard deviation.

    The errors of force, N, and deflection, m, are taken as independent and carried over at first order.

    Raises
    ------
    IllConditioned
        The deflection is not more than three standard deviations above zero, so the ratio has no useful bound.
    """
    for name, estimate in (("force", force), ("deflection", deflection)):
        if not (math.isfinite(estimate.value) and math.isfinite(estimate.sd) and estimate.sd >= 0):
            raise InvalidInput(f"{name} must be finite with a standard deviation of 0 or more, not {estimate}")
    if force.value < 0:
        raise InvalidInput(f"force must be at least 0 N, not {force.value}")
    if deflection.value <= _SIGNIFICANT * deflection.sd or deflection.value == 0:
        lost, error = (format_quantity(v, KINDS["Length"]) for v in (deflection.value, deflection.sd))
        raise IllConditioned(
            f"the object lost {lost} of height with a standard deviation of {error}: too little to tell"
        )
    stiffness = force.value / deflection.value
    return Estimate(stiffness, math.hypot(force.sd, stiffness * deflection.sd) / deflection.value)
