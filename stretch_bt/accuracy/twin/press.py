"""One press of a scene's object: the height and the length of the part that stands out of the membrane, and the force."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.errors import NoContact
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.perception.cells import cells_of
from stretch_bt.simulation.scene import Scene

__all__ = ["highest", "length_at", "press_once"]

_CLEAR = 0.004  # m above the top where a press begins
_SPEED = 0.005  # m/s
_READINGS = 20
_TOP = 0.002  # m round the middle that counts as the top
_BAND = 0.003  # m to either side of the line along which the length is taken
_BIN = 0.0005  # m
_HIGH = 0.8  # of the height of the top

Points = npt.NDArray[np.float64]


def press_once(scene: Scene, seed: int) -> dict[str, float]:
    """Return the height of the top, m, the length at four fifths of it, m, and the force, N, of a press.

    The length is along y, towards the clamps: on the other axis the free sides of the sheet rise as well.
    """
    bench, use = Bench(scene, seed), scene.conditions
    place = scene.object.position
    above = Pose((place.x, place.y, scene.object.top + _CLEAR))
    bench.stretch(use.stretch)
    bench.go(above, 0.1)
    bench.go(above.at_height(scene.object.top - use.depth), _SPEED)
    bench.time += use.hold / 2
    frame = bench.frame(use.frames)
    points = _points(frame)
    top = _mean(points[np.hypot(points[:, 0], points[:, 1]) < _TOP, 2])
    found = {"height": top + (frame.hand_height or 0.0), "size": length_at(points, _HIGH * top)}
    return {**found, "force": bench.force(_READINGS)}


def highest(frame: DepthFrame) -> float:
    """Return the world height, m, of the highest place of a size of 2 mm."""
    points = _points(frame)
    cells = cells_of(np.round(points[:, :2] / _TOP).astype(np.int64))
    return float(cells.means(points[:, 2])[cells.counts > cells.counts.max() / 2].max()) + (frame.hand_height or 0.0)


def _points(frame: DepthFrame) -> Points:
    points, valid = deproject(frame)
    seen: Points = np.asarray(to_membrane(points, frame.plane_distance or 0.0)[valid], dtype=np.float64)
    return seen


def length_at(points: Points, level: float) -> float:
    """Return how far apart along y the places lie, m, where the surface comes up through a level and goes down again."""
    line = points[np.abs(points[:, 0]) < _BAND]
    place = np.round(line[:, 1] / _BIN).astype(int)
    known, which, counts = np.unique(place, return_inverse=True, return_counts=True)
    profile = np.bincount(which, line[:, 2]) / counts
    above = np.flatnonzero(profile > level)
    if len(above) == 0 or above[0] == 0 or above[-1] == len(profile) - 1:
        return math.nan
    return float(_crossing(known, profile, above[-1], level) - _crossing(known, profile, above[0] - 1, level)) * _BIN


def _crossing(known: npt.NDArray[np.int64], profile: Points, left: int, level: float) -> float:
    """Return where a profile passes a level between a place and the next one."""
    part = (level - profile[left]) / (profile[left + 1] - profile[left])
    return float(known[left] + part * (known[left + 1] - known[left]))


def _mean(values: Points) -> float:
    if len(values) == 0:
        raise NoContact("no pixel shows the top")
    return float(values.mean())
