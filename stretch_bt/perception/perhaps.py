"""A quantity that is 0 or, by some odds, one of a known distribution, once it is seen with an error."""

from __future__ import annotations

import math

from stretch_bt.units import Estimate

__all__ = ["mixed", "odds_about", "perhaps_above"]

LEAST_SD = 1e-12
SURE_ODDS = 1e12
SURELY = 700.0  # exponent beyond which a number leaves the range of floats


def perhaps_above(seen: Estimate, spread: float) -> Estimate:
    """Return the quantity that is 0 or, as likely, half-normal with a `spread`."""
    seen = Estimate(seen.value, max(seen.sd, LEAST_SD))
    total = seen.sd**2 + spread**2
    middle, sd = seen.value * spread**2 / total, seen.sd * spread / math.sqrt(total)
    t = middle / sd
    if t < -30.0:  # so surely none that the tail is less than any number
        return Estimate(0.0, 0.0)
    above = max(0.5 * math.erfc(-t / math.sqrt(2.0)), 1e-300)
    hazard = math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi) / above
    odds = (
        2.0
        * above
        * seen.sd
        / math.sqrt(total)
        * math.exp(min(0.5 * (seen.value / seen.sd) ** 2 * spread**2 / total, SURELY))
    )
    return mixed(odds, middle + sd * hazard, sd * sd * max(1.0 - t * hazard - hazard**2, 0.0))


def odds_about(seen: Estimate, about: Estimate) -> float:
    """Return how many times likelier something is seen where it is normal `about` a value than where it is 0."""
    sd = max(seen.sd, LEAST_SD)
    total = sd**2 + about.sd**2
    likelier = 0.5 * ((seen.value / sd) ** 2 - (seen.value - about.value) ** 2 / total)
    return sd / math.sqrt(total) * math.exp(min(max(likelier, -SURELY), SURELY))


def mixed(odds: float, mean: float, variance: float) -> Estimate:
    """Return the quantity that is 0 or, `odds` times as likely, has a mean and a variance."""
    share = 1.0 if odds > SURE_ODDS else odds / (1.0 + odds)
    return Estimate(share * mean, math.sqrt(share * variance + share * (1.0 - share) * mean**2))
