"""How much of a domain is measured where little time is given."""

from __future__ import annotations

import math

from stretch_bt.accuracy.job import Job

__all__ = ["QUICK", "Budget"]

QUICK = 6.0  # CPU s of a domain
_WARM = 2.0  # of these, kept for the runs before the first point


class Budget:
    """Takes jobs as long as they fit, by the time they should take and the time that earlier ones took."""

    def __init__(self, quick: bool) -> None:
        self.limit = QUICK - _WARM if quick else math.inf
        self.expected = self.spent = 0.0
        self.dropped: set[str] = set()

    def takes(self, job: Job) -> bool:
        """Return whether a job fits; with the first of a group that does not, the rest of the group does not either."""
        slow = max(self.spent / self.expected, 1.0) if self.expected else 1.0
        fits = job.group not in self.dropped and (
            self.limit == math.inf or self.spent + slow * job.seconds <= self.limit
        )
        if not fits and job.group:
            self.dropped.add(job.group)
        return fits

    def spend(self, job: Job, seconds: float) -> None:
        """Note the time that a job took, CPU s."""
        self.expected += job.seconds
        self.spent += seconds
