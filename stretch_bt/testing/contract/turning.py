"""A clause for an arm, whose hand also turns."""

from __future__ import annotations

import math

import pytest

from stretch_bt.testing.contract.cut import CutMotionClauses
from stretch_bt.testing.contract.trial import angle, fault

__all__ = ["ArmClauses"]

#: from the middle of the membrane to its edge, m: there a hand that is turned is as far off as one that is shifted
_EDGE = 0.05


class ArmClauses(CutMotionClauses):
    """Clauses on the pose of a hand."""

    needs = ("moves",)

    def test_the_hand_turns_as_it_is_sent(self) -> None:
        """A membrane that is not as it was sent touches with one edge first: rotations are sent, and read, as positions are."""
        trial, tolerance = self.trial, self.contract.tolerance
        device = trial.open()
        first, last = trial.moves
        if _EDGE * angle(first, last) <= 2 * tolerance:
            pytest.skip(
                "the two poses of `moves` have the same rotation; name two that differ, as by 0.2 rad, to test that the hand turns"
            )
        trial.go(device, first)
        trial.go(device, last)
        self._settle(device)
        off, still = angle(trial.place(device), last), angle(trial.place(device), first)
        if _EDGE * off > tolerance:
            why = (
                "rotations are not sent, or not read"
                if _EDGE * still <= tolerance
                else "rotations are rotation vectors, rad, in world axes"
            )
            fault(
                f"the hand is {math.degrees(off):.1f}° off the rotation that it was sent to, at most "
                f"{math.degrees(tolerance / _EDGE):.2g}° allowed, {1e3 * tolerance:g} mm at the edge of the membrane: {why}"
            )
