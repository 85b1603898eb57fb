"""The error of the hand's height that its arm reports, by the effects of a scene."""

from __future__ import annotations

import math

from stretch_bt.frames import Pose
from stretch_bt.hardware.simulated.twin import Twin

__all__ = ["HeightError"]

#: a hand for which no pose was reported for so long, s, begins a new move with the next pose
_REST = 0.1
#: on the first part of a move, m, its error takes the place of the one before
_WAY = 1e-3


class HeightError:
    """The error of the height that each move of one hand ends at.

    Parameters
    ----------
    twin
        The twin with the effects, and the seed of their draws.
    """

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._moves = 0
        self._error = self._next = 0.0
        self._time, self._told = -math.inf, Pose()

    def true(self, time: float, told: Pose) -> Pose:
        """Return the true pose of the hand, at a time, s, at which its arm reports a pose."""
        if time - self._time > _REST:
            self._moves += 1
            self._next = self._drawn()
        way = math.dist(told.position, self._told.position)
        self._error += (self._next - self._error) * min(way / _WAY, 1.0)
        self._time, self._told = time, told
        return told.moved(z=self._error) if self._error else told

    def _drawn(self) -> float:
        twin = self._twin
        return sum(effect.height_error(twin.random(f"Arm {effect.name}", self._moves)) for effect in twin.robot)
