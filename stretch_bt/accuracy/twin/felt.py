"""Contacts of presses around a scene's object, as a tree gets them, without a tree."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import reduce

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.errors import NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception import Cloud, FreeView, find_contact, fuse_contact, with_left_over, without_pattern
from stretch_bt.perception.types import Contact
from stretch_bt.simulation.scene import Scene

__all__ = ["around", "felt", "fused"]

_CLEAR = 0.030  # m above the top, where the membrane is looked at
_FREE = 24  # frames of the free membrane
_SETTLE = 0.5  # s
_TRAVEL, _PRESS = 0.1, 0.005  # m/s


def around(scene: Scene) -> list[tuple[float, float]]:
    """Return world places (x, y), m, of presses over an object: its middle, and some way out along its axes."""
    place, heading, reach = scene.object.position, scene.object.heading, scene.object.reach
    far, near = min(0.6 * reach, 0.020), min(0.4 * reach, 0.010)
    ways = [(0.0, 0.0), (far, 0.0), (-far, 0.0), (0.0, near), (0.0, -near)]
    c, s = math.cos(heading), math.sin(heading)
    return [(place.x + c * u - s * v, place.y + s * u + c * v) for u, v in ways]


def felt(
    scene: Scene,
    seed: int,
    places: Iterable[tuple[float, float]],
    depth: float,
    *,
    stretch: float = 0.0,
    frames: int = 24,
) -> list[Contact]:
    """Return one contact of each place, pressed to a depth below the object's top, m.

    Before each press the hand looks at its free membrane and learns the camera's static error, as `approach` does.

    Raises
    ------
    NoContact
        Nothing is felt at a place.
    NoEquilibrium
        A press has none.
    """
    bench = Bench(scene, seed)
    bench.stretch(stretch)
    top = scene.object.top
    found = []
    for x, y in places:
        above = Pose((x, y, top + _CLEAR))
        bench.go(above, _TRAVEL)
        geometry, free = bench.cell.hand.geometry, FreeView()
        for shot in bench.shots(_FREE):
            free.add(shot)
        free.settle()
        pattern = free.pattern(geometry.gauge, width=geometry.width)
        bench.go(above.at_height(top - depth), _PRESS)
        bench.time += _SETTLE
        frame = bench.frame(frames)
        bench.go(above, _TRAVEL)
        if pattern is None:
            found.append(find_contact(frame))
        else:
            found.append(with_left_over(find_contact(without_pattern(frame, pattern)), pattern))
    return found


def fused(contacts: Iterable[Contact]) -> Cloud:
    """Return the cloud of contacts; raises NoContact where there is none."""
    cloud = reduce(lambda before, contact: fuse_contact(contact, before), contacts, None)
    if cloud is None:
        raise NoContact("there is no contact to fuse")
    return cloud
