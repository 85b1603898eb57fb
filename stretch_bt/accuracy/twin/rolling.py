"""A roll of a lump of dough round a figure of eight, and the rest of its corners."""

from __future__ import annotations

import math

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.accuracy.twin.press import highest
from stretch_bt.frames import Pose
from stretch_bt.simulation.scene import Scene

__all__ = ["roll_once"]

_LONG, _WIDE = 0.045, 0.018  # m, half the size of the figure of eight
_STEPS = 48  # poses to a lap
_LAP = 0.27  # m, its length, for how many there are
_SPEED = 0.1  # m/s
_CLEAR = 0.004


def roll_once(scene: Scene, seed: int) -> dict[str, float]:
    """Return the roundness of a lump after rolling, by the twin, and the height of its top, m, as it is measured."""
    bench, use = Bench(scene, seed), scene.conditions
    start = Pose((0.0, 0.0, scene.object.top + _CLEAR))
    bench.stretch(use.stretch)
    bench.go(start, 0.1)
    low = start.at_height(scene.object.top - use.depth)
    bench.go(low, 0.005)
    for _ in range(max(round(use.travel / _LAP), 1)):
        angles = [2 * math.pi * k / _STEPS for k in range(1, _STEPS + 1)]
        path = [low.moved(_LONG * math.sin(a), 2 * _WIDE * math.sin(a) * math.cos(a)) for a in angles]
        bench.wait(bench.devices["arm"].follow(path, speed=_SPEED, owner="bench"))
    found = {"height": highest(bench.frame(use.frames))}
    bench.go(start, 0.02)
    return {**found, "roundness": bench.cell.truth()["roundness"]}
