"""A part of an object that is softer below the largest drop that it has seen, as rubber is below its largest stretch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stretch_bt.simulation.balloons.memory import longest_step
from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Softened", "Stretched"]


@dataclass(frozen=True, slots=True)
class Stretched:
    """The largest drop so far, m, and the state of what is softened."""

    largest: float
    inner: Any


class Softened(Response):
    """A response less what softening takes off one part of it: F(d) = F1(d) - share (1 - d / m) part(d) below the largest drop m.

    At and past m the force is that of the first loading, as in the pseudo-elastic law of Ogden and Roxburgh (Proc. R. Soc. A
    455, 1999); `share` is what is lost just after the return.
    """

    def __init__(self, inner: Response, part: Law, share: float) -> None:
        self.inner, self.part, self.share = inner, part, share
        self.memory = longest_step(inner, float("inf"))

    def start(self) -> Stretched:
        """Nothing has pushed."""
        return Stretched(0.0, self.inner.start())

    def law(self, state: Stretched, dt: float) -> Law:
        """Return the force of what is softened by now."""
        first, largest = self.inner.law(state.inner, dt), state.largest

        def force(drop: float) -> tuple[float, float]:
            value, slope = first(drop)
            if drop >= largest or value <= 0:
                return value, slope
            part, part_slope = self.part(drop)
            left = self.share * (1 - drop / largest)
            return value - left * part, slope - left * part_slope + self.share * part / largest

        return force

    def kinks(self, state: Stretched) -> tuple[float, ...]:
        """Return where it was pressed to, m."""
        return (state.largest, *self.inner.kinks(state.inner))

    def after(self, state: Stretched, drop: float, dt: float) -> Stretched:
        """Return it after a step."""
        return Stretched(max(state.largest, drop), self.inner.after(state.inner, drop, dt))

    def rest(self, state: Stretched, dt: float) -> float:
        """Return the rest of what is softened, m: rubber comes back."""
        return self.inner.rest(state.inner, dt)
