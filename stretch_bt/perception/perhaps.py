"""Estimates of a quantity that may be one thing or another, or is seen twice."""

from __future__ import annotations

import math

from stretch_bt.units import Estimate

__all__ = ["either", "odds_about", "perhaps_above", "weighed"]

LEAST_SD = 1e-12
SURE_ODDS = 1e12
SURELY = 700.0  # exponent beyond which a number leaves the range of floats
FAR = 30.0  # standard deviations: what a normal distribution leaves farther out lies within a thirtieth of one of where it is cut
EVENLY = math.sqrt(12.0)  # of a range, over the standard deviation of what lies anywhere in it


def perhaps_above(seen: Estimate, most: float) -> Estimate:
    """Return the quantity that is 0 or, as likely before it is seen, anything from 0 to `most`."""
    sd, most = max(seen.sd, LEAST_SD), max(most, LEAST_SD)
    low, high = -seen.value / sd, (most - seen.value) / sd  # of a normal distribution that is cut at 0 and at `most`
    if low > FAR:
        return Estimate(0.0, 0.0)
    if high < -FAR:
        return Estimate(most, 0.0)
    within = max(_below(high) - _below(low) if low < 0.0 else _below(-low) - _below(-high), 1e-300)
    off = (_density(low) - _density(high)) / within
    variance = 1.0 + (low * _density(low) - high * _density(high)) / within - off * off
    there = Estimate(min(max(seen.value + sd * off, 0.0), most), min(sd * math.sqrt(max(variance, 0.0)), most / EVENLY))
    likelier = math.sqrt(2.0 * math.pi) * within * math.exp(min(0.5 * low * low, SURELY))
    return either(likelier * sd / most, there, Estimate(0.0, 0.0))


def _density(t: float) -> float:
    return math.exp(-0.5 * t * t) / math.sqrt(2.0 * math.pi)


def _below(t: float) -> float:
    return 0.5 * math.erfc(-t / math.sqrt(2.0))


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
