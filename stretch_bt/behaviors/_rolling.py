"""The closed paths along which a hand rolls an object under it."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

from stretch_bt.frames import Pose

__all__ = ["PATHS", "laid", "length_of"]

Place = tuple[float, float]

#: width of an eight over half of its length
WAIST = 0.8


def _circle(angle: float) -> Place:
    """Return the place on a circle of radius 1 that begins in the origin, its centre on the side of -x."""
    return math.cos(angle) - 1, math.sin(angle)


def _eight(angle: float) -> Place:
    """Return the place on a figure-eight that begins in its middle, its axis along y, half of its length 1.

    Its two opposite turns do not commute, so a lap is no rotation about one axis of the lump and each brings other places
    under the hand; a circle repeats one rotation for ever.
    """
    return WAIST * math.sin(angle) * math.cos(angle), math.sin(angle)


PATHS: dict[str, Callable[[float], Place]] = {"circle": _circle, "eight": _eight}


def laid(shape: str, radius: float, start: Pose, first: float, last: float, steps: int) -> list[Pose]:
    """Return poses from one part of a lap to another, each from 0 to 1, of a path that began at a pose, at its height.

    The path has the hand's axes: y along the stretch.
    """
    matrix = start.matrix()
    poses = []
    for k in range(steps + 1):
        u, v = PATHS[shape](2 * math.pi * (first + (last - first) * k / steps))
        poses.append(start.moved(*(radius * (matrix[i, 0] * u + matrix[i, 1] * v) for i in (0, 1))))
    return poses


def length_of(poses: list[Pose]) -> float:
    """Return the length of straight lines through poses, m."""
    return sum(math.dist(one.position, other.position) for one, other in pairwise(poses))
