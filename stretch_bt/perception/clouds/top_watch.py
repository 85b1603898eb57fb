"""Watching whether the top of an object gives way under a press."""

from __future__ import annotations

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame
from stretch_bt.perception.clouds.views import surface_of
from stretch_bt.perception.deprojection import to_world
from stretch_bt.units import Length

__all__ = ["TopWatch"]

LATEST = 3  # looks whose mean shows whether the top has fallen
APART = 0.8e-3  # m that the hand sinks between them at least: from one frame to the next little changes
AROUND = 0.003  # m round the highest place


class TopWatch:
    """Compares the highest place (x, y, z), m, world, that was felt with where it is seen now; one that is out of sight has not fallen."""

    def __init__(self, place: tuple[float, float, float]) -> None:
        self.place = place
        self._tops: list[float] = []
        self._looked = -np.inf

    def is_due(self, depth: Length) -> bool:
        """Return whether the hand is deep enough, m, for another look."""
        return bool(depth >= self._looked + APART)

    def fell(self, frame: DepthFrame, depth: Length, by: Length) -> bool:
        """Take a look at a depth of the hand, m, and return whether the top stands lower than it was felt by so much, m.

        Raises
        ------
        InvalidInput
            The frame does not say where the hand is.
        """
        self._looked = depth
        if frame.pose is None:
            raise InvalidInput("the frame does not say where the hand is; declare an arm")
        x, y, height = self.place
        world = to_world(surface_of(frame).reshape(-1, 3), frame.pose)
        near = world[np.hypot(world[:, 0] - x, world[:, 1] - y) < AROUND, 2]
        if len(near):
            self._tops = [*self._tops, float(near.mean())][-LATEST:]
        return len(self._tops) == LATEST and float(np.mean(self._tops)) < height - by
