"""A part of an object that is softer below the largest drop that it has seen, as rubber is below its largest stretch."""

from __future__ import annotations

from stretch_bt.simulation.balloons.largest import LargestDrop, RemembersLargest
from stretch_bt.simulation.objects.response import Law, Response

__all__ = ["Softened"]


class Softened(RemembersLargest):
    """A response less the softening of one part of it: F(d) = F1(d) - share (1 - d / m) part(d) below the largest drop m.

    At and past m the force equals the first loading's, as in the pseudo-elastic law of Ogden and Roxburgh (Proc. R. Soc. A
    455, 1999); `share` is the part lost just after the return.
    """

    def __init__(self, inner: Response, part: Law, share: float) -> None:
        super().__init__(inner)
        self.part, self.share = part, share

    def law(self, state: LargestDrop, dt: float) -> Law:
        """Return the force with the softening so far."""
        first, largest = self.inner.law(state.inner, dt), state.largest

        def force(drop: float) -> tuple[float, float]:
            value, slope = first(drop)
            if drop >= largest or value <= 0:
                return value, slope
            part, part_slope = self.part(drop)
            left = self.share * (1 - drop / largest)
            return value - left * part, slope - left * part_slope + self.share * part / largest

        return force
