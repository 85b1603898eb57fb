"""How far along its path a motion is at each time."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Profile"]

_Phase = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Profile:
    """Phases of constant acceleration, each (time, distance, speed, acceleration) at its begin, SI; then rest."""

    phases: tuple[_Phase, ...]
    duration: float
    length: float

    @classmethod
    def trapezoid(cls, length: float, speed: float, acceleration: float) -> Profile:
        """Return a motion of `length` that begins and ends at rest."""
        peak = min(speed, math.sqrt(length * acceleration))
        if peak == 0:
            return cls((), 0.0, 0.0)
        ramp = peak / acceleration
        cruise = length / peak - ramp
        rise = peak * ramp / 2
        phases = (
            (0.0, 0.0, 0.0, acceleration),
            (ramp, rise, peak, 0.0),
            (ramp + cruise, rise + peak * cruise, peak, -acceleration),
        )
        return cls(phases, 2 * ramp + cruise, length)

    def at(self, time: float) -> tuple[float, float]:
        """Return distance, m, and speed, m/s, at a time, s, after the begin."""
        if time >= self.duration:
            return self.length, 0.0
        if time <= 0:
            return 0.0, 0.0
        begin, distance, speed, rate = next(p for p in reversed(self.phases) if p[0] <= time)
        since = time - begin
        return distance + speed * since + rate * since**2 / 2, speed + rate * since

    def when(self, distance: float) -> float:
        """Return the time, s, after the begin, at which it is this far along, m, from 0 to its length."""
        if distance >= self.length:
            return self.duration
        begin, before, speed, rate = next(p for p in reversed(self.phases) if p[1] <= distance)
        left = distance - before
        mean = (speed + math.sqrt(max(speed**2 + 2 * rate * left, 0.0))) / 2
        return begin + left / mean if left > 0 else begin

    def braked(self, time: float, acceleration: float) -> Profile:
        """Return the same motion, brought to rest from this time on."""
        if time >= self.duration:
            return self
        start = max(time, 0.0)
        distance, speed = self.at(start)
        kept = tuple(p for p in self.phases if p[0] < start)
        end = start + speed / acceleration
        return Profile((*kept, (start, distance, speed, -acceleration)), end, distance + speed**2 / (2 * acceleration))
