"""What is known of the force that the controllers of each model show, and what follows for its filter and its zero."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["FORCE_SENSING", "ForceSensing", "sample_limit"]

#: least limit on a single sample, N, and how far above the limit on the average it is: five to six deviations of a CB3's noise
_SAMPLE, _ABOVE = 40.0, 20.0
#: how many deviations of a mean are taken for noise
_DEVIATIONS = 4.0


@dataclass(frozen=True)
class ForceSensing:
    """Of one model.

    Parameters
    ----------
    deviation
        Standard deviation of a sample, N an axis.
    bias
        Force that it shows with nothing touching it, at most, N.
    filter
        Time over which it is averaged, s.
    zero_over
        Time over which its zero is averaged, s.
    zeroed_at_start
        Whether the controller takes the force at the start of each program as zero.
    """

    deviation: float
    bias: float
    filter: float
    zero_over: float
    zeroed_at_start: bool

    def explained(self, count: int) -> float:
        """Return the largest force, N, that bias and noise make of a mean of so many samples with nothing touching the hand."""
        return self.bias + _DEVIATIONS * self.deviation / math.sqrt(max(count, 1))


def sample_limit(limit: float) -> float:
    """Return the limit on a single sample of the force, N, for a limit on its average, N: one that noise does not reach."""
    return max(_SAMPLE, limit + _ABOVE)


#: A CB3 estimates the force from joint currents: 3.6 N of deviation were measured, +-10 N are quoted (forum of Universal Robots, topic 229).
#: 16 samples leave 0.9 N an axis, with which a limit of 5 N is crossed by noise less than once an hour. A UR5e has a sensor, of 4 N
#: accuracy by its data sheet; its noise is not published, and taken from the FT 300 of the same topic, 0.6 N: 4 samples leave 0.3 N.
FORCE_SENSING = {
    "ur5": ForceSensing(deviation=3.6, bias=10.0, filter=0.128, zero_over=0.5, zeroed_at_start=False),
    "ur5e": ForceSensing(deviation=0.6, bias=4.0, filter=0.032, zero_over=0.2, zeroed_at_start=True),
}
