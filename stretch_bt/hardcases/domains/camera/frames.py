"""The simulated camera under noise of any size, and the sizes that its effects state."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.hardcases.domains.camera.noise import EFFECTS
from stretch_bt.hardcases.expect import Check, Range
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.base import Size
from stretch_bt.simulation.scene import parse_scene

HEAD = "format: stretch-scene/1\n"
BALL = "object: {type: sphere, diameter: 20 mm, rigid: true, base: 20 mm}\n"
#: effects, and the part of the pixels of the membrane that has a value
NOISES = {
    "{white_noise: {sd: 0 mm}}": (0.9, 1.0),
    "{white_noise: {sd: 50 mm}}": (0.9, 1.0),
    "{correlated_noise: {sd: 50 mm}}": (0.9, 1.0),
    "{fixed_pattern: {sd: 0 mm}}": (0.9, 1.0),
    "{dropout: {share: 1.0}}": (0.0, 0.0),
}
THINGS = {
    "a ball": "{type: sphere, diameter: 50 mm, rigid: true}",
    "a face": "{type: cylinder, diameter: 20 mm, height: 40 mm, rigid: true}",
}


def _seen(effects: str) -> float:
    """Return the part of the pixels of the membrane that has a value."""
    cell = open_cell(load_cell("simulated"), now=lambda: 1.0, scene=parse_scene(f"{HEAD}{BALL}effects: {effects}\n"))
    camera: Any = cell.devices["camera"]
    frame = camera.frame(1.0).value
    return float(np.mean(frame.depth[100:-100, 60:-60] > 0))


def _sizes(name: str, thing: str, depth: str) -> list[Size]:
    conditions = f"conditions: {{stretch: 30 mm, depth: {depth}, frames: 4}}\ncamera: bench\n"
    scene = parse_scene(f"{HEAD}object: {THINGS[thing]}\n{conditions}")
    effect = EFFECTS[name]
    return list(effect.sizes(Case(scene, scene.object.rough()), scene.parameters(effect)))


def _finite(found: list[Size]) -> bool:
    return all(0 <= size.value < math.inf and size.why for size in found)


CASES: tuple[Hard, ...] = (
    *group(
        "noise of no size, as large as the scene, or that leaves nothing",
        {f"frames with {effects}": (partial(_seen, effects), Range(*part)) for effects, part in NOISES.items()},
    ),
    *group(
        "the size of an effect is divided by the pixels of the contact, which may be none or the whole membrane",
        {
            f"size of {name} on {thing}, {depth}": (
                partial(_sizes, name, thing, depth),
                Check("every size finite, at least 0, with a reason", _finite),
            )
            for name in EFFECTS
            for thing in THINGS
            for depth in ("0.2 mm", "30 mm")
        },
    ),
)
