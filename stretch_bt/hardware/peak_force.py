"""The largest force between the hand and what it meets: a limit of force is where an arm begins to stop, not where it stands.

The hand moves at a constant speed v towards something; hand and object together have the stiffness k. From the touch on the force grows as
k v t. The arm compares two forces with limits: the mean over the last T seconds with F, and each reading with R.

- The mean over T lags. While part of its window is before the touch it is k v t^2 / (2 T), after that k v (t - T / 2). It reaches F at
  t = F / (k v) + T / 2 where F >= k v T / 2, and at t = sqrt(2 F T / (k v)) below that. Both are the same at F = k v T / 2.
- A reading reaches R at t = R / (k v).
- The earlier of the two is noticed. The arm begins to brake at most D later, and goes on by v^2 / (2 a) while it brakes at a.

So the force ends at k (v (t + D) + v^2 / (2 a)). A hand that presses already, with less than F, ends at less: its mean is ahead.

A connection that holds readings back for less than the time B after which it counts as lost makes all of that later by B. One that breaks
leaves the hand at its last setpoint, which it is v L behind. So the force ends at k (v (t + D + B) + max(v^2 / (2 a), v L)) at most.

Left out: noise and an error of the zero, which move F by as much as they are; that the arm may still be gaining speed, and that what it
meets holds it back. The last two make the true force smaller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["PeakForce", "Stopping", "fastest_for", "peak_force"]

#: halvings of an interval of speeds: to a 2^40th of it
_HALVINGS = 40


@dataclass(frozen=True, slots=True)
class Stopping:
    """How an arm stops because of a force, SI.

    Parameters
    ----------
    averaged
        Time T over which the force is averaged that is compared with `limits.force`, s; 0 for single readings.
    single
        Limit R of a single reading, N; infinite where there is none.
    delay
        Longest time D from a force at the hand until the arm begins to brake, s.
    deceleration
        Least deceleration a of the hand, m/s².
    late
        Longest time B for which a connection holds readings back and does not yet count as lost, s.
    lag
        Delay L of the hand behind its setpoint, s.
    """

    averaged: float
    single: float
    delay: float
    deceleration: float
    late: float
    lag: float


@dataclass(frozen=True, slots=True)
class PeakForce:
    """The largest force, N: over a connection that is in order, and over one that holds readings back or breaks."""

    stopped: float
    late: float


def peak_force(speed: float, stiffness: float, limit: float, stopping: Stopping) -> PeakForce:
    """Return the largest force on something that the hand meets on its way; the derivation is at the top of the module.

    Parameters
    ----------
    speed
        Speed of the hand, m/s, above 0.
    stiffness
        Stiffness of hand and object together, N/m, above 0.
    limit
        Force F at which the arm is stopped, N.
    stopping
        How the arm stops.
    """
    s = stopping
    before, braking = speed * (_noticed(stiffness * speed, limit, s) + s.delay), speed**2 / (2 * s.deceleration)
    late = before + speed * s.late + max(braking, speed * s.lag)
    return PeakForce(stiffness * (before + braking), stiffness * late)


def fastest_for(peak: float, stiffness: float, limit: float, stopping: Stopping, most: float) -> float | None:
    """Return the highest speed, m/s, up to `most` at which a stop ends at no more than a force, N; None where none does.

    A speed close to 0 ends at the limit itself, so that there is one for every `peak` above `limit`.
    """
    if peak <= limit:
        return None
    low, high = 0.0, most
    if peak_force(high, stiffness, limit, stopping).stopped <= peak:
        return high
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if peak_force(middle, stiffness, limit, stopping).stopped <= peak else (low, middle)
    return low


def _noticed(rate: float, limit: float, stopping: Stopping) -> float:
    """Return the time from the touch until a force that grows at a rate, N/s, is past a limit, s."""
    window = stopping.averaged
    filled = limit >= rate * window / 2
    mean = limit / rate + window / 2 if filled else math.sqrt(2 * limit * window / rate)
    return min(mean, stopping.single / rate)
