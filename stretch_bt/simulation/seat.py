"""From where an object stands in the world and where the hand is to where the object stands in the membrane frame."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.frames import Pose
from stretch_bt.simulation.objects.base import Standing

__all__ = ["Seat", "seat"]

_UPRIGHT = 1e-9
_MIRROR = np.diag([1.0, -1.0, 1.0])  # the membrane frame's y is reversed against the hand's


class Seat(NamedTuple):
    """The axis of an object pierces the membrane at `at`, m, turned by `heading` and then by `tilt`, rad.

    `depth` is how far the object's highest point is past the plane of the membrane, m, and `upright` the cosine of the tilt.
    """

    at: tuple[float, float]
    heading: float
    tilt: tuple[float, float]
    depth: float
    upright: float


def seat(standing: Standing, pose: Pose) -> Seat:
    """Return where an object on the table stands in the frame of a membrane at a pose."""
    rotation = pose.matrix()
    if rotation[2, 2] > 1 - _UPRIGHT:
        (x, y), yaw = _across(standing, pose, rotation), math.atan2(rotation[1, 0], rotation[0, 0])
        return Seat((x, y), _wrapped(yaw - standing.heading), (0.0, 0.0), standing.top - pose.height, 1.0)
    return _tilted(standing, pose, rotation)


def _across(standing: Standing, pose: Pose, rotation: np.ndarray) -> tuple[float, float]:
    offset = np.array([standing.x - pose.position[0], standing.y - pose.position[1]])
    x, y = rotation[:2, :2].T @ offset
    return float(x), -float(y)


def _tilted(standing: Standing, pose: Pose, rotation: np.ndarray) -> Seat:
    """Return the seat by the angles of a turn about z, then x, then y, which is how bodies are placed under the sheet."""
    from stretch_bt.simulation.membrane.indenters.placed import origin_below_top, rise
    from stretch_bt.simulation.membrane.indenters.turned import turn

    c, s = math.cos(standing.heading), math.sin(standing.heading)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    seen = _MIRROR @ rotation.T @ turned @ _MIRROR
    about_x = math.asin(-min(max(seen[1, 2], -1.0), 1.0))
    about_y = math.atan2(seen[0, 2], seen[2, 2])
    heading = math.atan2(seen[1, 0], seen[1, 1])
    if standing.body is None:
        raise NoEquilibrium("a tilted hand has no answer over an object wider than the membrane")
    origin = np.array([standing.x, standing.y, standing.top - origin_below_top(standing.body)])
    place = _MIRROR @ rotation.T @ (origin - np.array(pose.position))
    depth = float(place[2]) + rise(turn(standing.body, heading), (about_x, about_y))
    return Seat((float(place[0]), float(place[1])), heading, (about_x, about_y), depth, float(rotation[2, 2]))


def _wrapped(angle: float) -> float:
    turns = math.remainder(angle, 2 * math.pi)
    return 0.0 if abs(turns) < 1e-12 else turns
