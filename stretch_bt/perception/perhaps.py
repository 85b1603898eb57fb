"""Estimates of a quantity that may be one thing or another, or is seen twice."""

from __future__ import annotations

import math

from stretch_bt.units import Estimate

__all__ = ["either", "odds_about", "perhaps_above", "weighed"]

LEAST_SD = 1e-12
SURE_ODDS = 1e12
SURELY = 700.0  # exponent beyond which a number leaves the range of floats


def perhaps_above(seen: Estimate, most: float) -> Estimate:
    """Return the quantity that is 0 or, as likely, above, as dense everywhere as if it were spread evenly up to `most`."""
    seen = Estimate(seen.value, max(seen.sd, LEAST_SD))
    t = seen.value / seen.sd
    if t < -30.0:  # so surely none that the tail is less than any number
        return Estimate(0.0, 0.0)
    above = max(0.5 * math.erfc(-t / math.sqrt(2.0)), 1e-300)
    hazard = math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi) / above
    odds = math.exp(min(0.5 * t * t, SURELY)) * math.sqrt(2.0 * math.pi) * seen.sd * above
    there = Estimate(seen.value + seen.sd * hazard, seen.sd * math.sqrt(max(1.0 - t * hazard - hazard**2, 0.0)))
    return either(odds / max(most, LEAST_SD), there, Estimate(0.0, 0.0))


def odds_about(seen: Estimate, about: Estimate) -> float:
    """Return how many times likelier something is seen where it is normal `about` a value than where it is 0."""
    sd = max(seen.sd, LEAST_SD)
    total = sd**2 + about.sd**2
    likelier = 0.5 * ((seen.value / sd) ** 2 - (seen.value - about.value) ** 2 / total)
    return sd / math.sqrt(total) * math.exp(min(max(likelier, -SURELY), SURELY))


def either(odds: float, one: Estimate, other: Estimate) -> Estimate:
    """Return the quantity that is `one` or, by the odds of that against it, the `other`."""
    share = 1.0 if odds > SURE_ODDS else odds / (1.0 + odds)
    mean = share * one.value + (1.0 - share) * other.value
    within = share * one.sd**2 + (1.0 - share) * other.sd**2
    return Estimate(mean, math.sqrt(within + share * (1.0 - share) * (one.value - other.value) ** 2))


def weighed(one: Estimate, other: Estimate) -> Estimate:
    """Return the mean of two estimates of a quantity, weighed by their variances, whose errors have nothing in common."""
    total = max(one.sd**2 + other.sd**2, LEAST_SD**2)
    mean = (one.value * other.sd**2 + other.value * one.sd**2) / total
    return Estimate(mean, one.sd * other.sd / math.sqrt(total))
