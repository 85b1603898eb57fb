"""A response less a force that is known by the drop."""

from __future__ import annotations

from typing import Any

from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Lessened"]


class Lessened(Response):
    """The response `inner` less `taken`, which is at most its force; no memory but the inner's."""

    def __init__(self, inner: Response, taken: Law) -> None:
        self.inner, self.taken = inner, taken
        self.memory = inner.memory

    def start(self) -> Any:
        """Return the inner's."""
        return self.inner.start()

    def law(self, state: Any, dt: float) -> Law:
        """Return the difference."""
        whole = self.inner.law(state, dt)

        def force(drop: float) -> tuple[float, float]:
            (value, slope), (less, by) = whole(drop), self.taken(drop)
            return value - less, slope - by

        return force

    def kinks(self, state: Any) -> tuple[float, ...]:
        """Return the inner's."""
        return tuple(self.inner.kinks(state))

    def after(self, state: Any, drop: float, dt: float) -> Any:
        """Return the inner's."""
        return self.inner.after(state, drop, dt)

    def rest(self, state: Any, dt: float) -> float:
        """Return the inner's, m."""
        return self.inner.rest(state, dt)
