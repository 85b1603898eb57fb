"""Straight lines through poses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import Final

from stretch_bt.frames import Pose

__all__ = ["LEVER", "PosePath", "between"]

#: lever, m, that turns a rotation into a distance, so that a turn on the spot takes time too
LEVER: Final = 0.1
_SHARP = math.cos(math.radians(45))  # of the angle between two legs


class PosePath:
    """A polyline of poses, by distance, m; rotation vectors are interpolated along with the position.

    The same orientation has many rotation vectors; of each pose that next to the one before it is taken, so that no hand near half a
    turn goes the long way round.
    """

    def __init__(self, poses: Sequence[Pose]) -> None:
        self.poses = list(accumulate(poses, _next_to))
        self.distances = [0.0]
        for one, other in zip(self.poses, self.poses[1:], strict=False):
            self.distances.append(self.distances[-1] + _distance(one, other))

    @property
    def length(self) -> float:
        """Length of the whole path, m."""
        return self.distances[-1]

    @property
    def corners(self) -> list[float]:
        """Distances, m, at which it turns sharply, by more than half a right angle, or the direction of its rotation changes so."""
        found, before = [], None
        for i, (one, other) in enumerate(pairwise(self.poses)):
            if self.distances[i + 1] > self.distances[i]:
                way = _way(one, other)
                if before is not None and sum(u * v for u, v in zip(before, way, strict=True)) < _SHARP:
                    found.append(self.distances[i])
                before = way
        return found

    def at(self, distance: float) -> Pose:
        """Return the pose this far along."""
        if distance >= self.length:
            return self.poses[-1]
        i = next(k for k, end in enumerate(self.distances[1:]) if distance < end)
        part = (distance - self.distances[i]) / (self.distances[i + 1] - self.distances[i])
        return between(self.poses[i], self.poses[i + 1], part)

    def above(self, floor: float) -> PosePath:
        """Return the path up to where it would go under a height, m, or the path itself."""
        for i, pose in enumerate(self.poses):
            if pose.height < floor:
                before = self.poses[max(i - 1, 0)]
                drop = before.height - pose.height
                part = min(max((before.height - floor) / drop, 0.0), 1.0) if drop > 0 else 0.0
                return PosePath([*self.poses[:i], between(before, pose, part)])
        return self


def _next_to(before: Pose, pose: Pose) -> Pose:
    """Return a pose with its rotation vector changed by full turns about its axis, so that it is nearest to the one before."""
    angle = math.hypot(*pose.rotation)
    turn = pose.rotation if angle > 0 else before.rotation
    axis = [v / (math.hypot(*turn) or 1.0) for v in turn]
    along = sum(a * b for a, b in zip(axis, before.rotation, strict=True))
    rounds = round((along - angle) / math.tau)
    if rounds == 0:
        return pose
    a, b, c = (v * (angle + math.tau * rounds) for v in axis)
    return Pose(pose.position, (a, b, c))


def _way(one: Pose, other: Pose) -> list[float]:
    """Return the direction from one pose to another that differs, of length 1: across, and turned by the lever."""
    across = [v - u for u, v in zip(one.position, other.position, strict=True)]
    turned = [LEVER * (v - u) for u, v in zip(one.rotation, other.rotation, strict=True)]
    length = math.hypot(*across, *turned)
    return [v / length for v in (*across, *turned)]


def _distance(one: Pose, other: Pose) -> float:
    return max(math.dist(one.position, other.position), LEVER * math.dist(one.rotation, other.rotation))


def between(one: Pose, other: Pose, part: float) -> Pose:
    """Return the pose that is a part, 0 to 1, of the way to another one."""
    p, q = ((*pose.position, *pose.rotation) for pose in (one, other))
    x, y, z, a, b, c = (u + part * (v - u) for u, v in zip(p, q, strict=True))
    return Pose((x, y, z), (a, b, c))
