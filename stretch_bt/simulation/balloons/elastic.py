"""A body that gives way by one law, whatever was before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Elastic"]


@dataclass(frozen=True)
class Elastic(Response):
    """The law itself: no memory."""

    by_drop: Law

    def law(self, state: Any, dt: float) -> Law:
        """Return the law."""
        return self.by_drop
