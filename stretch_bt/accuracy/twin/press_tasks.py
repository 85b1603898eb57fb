"""Random scenes to press, and the results of a press with some effects on and all others off: shared by benchmarks of the advisor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.twin.press import press_once
from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import NOISE, judge
from stretch_bt.simulation.camera.skin import Grid
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene import Scene, parse_scene
from stretch_bt.simulation.world import World

__all__ = [
    "OBJECTS",
    "REFERENCE",
    "PressFigures",
    "apart",
    "drawn",
    "possible",
    "pressed",
    "scene_with",
    "solved",
    "warm",
    "with_effects",
]

TOP, HIGH = 2e-3, 0.8  # m round the middle that counts as top, and share of the depth at which a length is taken
POINTS = 181  # along each side of a sheet
#: for the reference: elements two fifths as long as usual, that grow by 1.2
REFERENCE = Settings(coarsen=0.4, growth=1.2, budget=5000)

Item = TypeVar("Item")
Result = TypeVar("Result")


class PressFigures(NamedTuple):
    """Force, N; height of the membrane over the middle and its length at four fifths of the depth, m; CPU time, s."""

    force: float
    height: float
    size: float
    cpu: float


def _log(random: np.random.Generator, low: float, high: float) -> float:
    return math.exp(random.uniform(math.log(low), math.log(high)))


#: an object of each kind, drawn at random
OBJECTS: dict[str, Callable[[np.random.Generator], str]] = {
    "sphere": lambda r: f"type: sphere, diameter: {r.uniform(12, 70):.1f} mm, rigid: true",
    "cone": lambda r: (
        f"type: cone, angle: {r.uniform(15, 55):.1f} deg, height: 60 mm, tip: {_log(r, 0.5, 8):.2f} mm, rigid: true"
    ),
    "box": lambda r: (
        f"type: box, length: {r.uniform(12, 60):.1f} mm, width: {r.uniform(12, 50):.1f} mm, height: 60 mm, "
        f"edge: {r.uniform(0.4, 2.5):.2f} mm, heading: {r.uniform(-90, 90):.0f} deg, rigid: true"
    ),
    "balloon": lambda r: (
        f"type: balloon, diameter: {r.uniform(40, 75):.1f} mm, base: 30 mm, pressure: {r.uniform(1.5, 5):.2f} kPa, "
        f"fill: {{type: {r.choice(['water', 'air', 'seeds', 'pudding'])}}}"
    ),
    "cylinder": lambda r: (
        f"type: cylinder, diameter: {r.uniform(10, 60):.1f} mm, height: 60 mm, rim: {r.uniform(0.4, 2.5):.2f} mm, rigid: true"
    ),
    "prism": lambda r: (
        f"type: prism, length: {r.uniform(20, 60):.1f} mm, width: {r.uniform(25, 60):.1f} mm, height: {r.uniform(20, 40):.1f} mm, "
        f"edge: {r.uniform(0.5, 2):.2f} mm, heading: {r.uniform(-90, 90):.0f} deg, rigid: true"
    ),
    "half_cylinder": lambda r: (
        f"type: half_cylinder, diameter: {r.uniform(15, 60):.1f} mm, length: {r.uniform(15, 60):.1f} mm, "
        f"heading: {r.uniform(-90, 90):.0f} deg, rigid: true"
    ),
    "pyramid": lambda r: (
        f"type: pyramid, width: {r.uniform(30, 60):.1f} mm, height: {r.uniform(15, 40):.1f} mm, edge: {r.uniform(0.5, 2):.2f} mm, "
        f"heading: {r.uniform(-90, 90):.0f} deg, rigid: true"
    ),
    "wire_circle": lambda r: (
        f"type: wire_circle, diameter: {r.uniform(30, 60):.1f} mm, thickness: {r.uniform(1.5, 4):.1f} mm, base: 20 mm"
    ),
}


def drawn(random: np.random.Generator, kind: str, *, depth: tuple[float, float] = (3, 15)) -> str:
    """Return the text of a scene without its effects: an object, a stretch of 0 to 80 mm, slack in one of four, and a depth."""
    stretch = 0.0 if random.random() < 0.25 else random.uniform(0, 80)
    return (
        "format: stretch-scene/1\n"
        f"object: {{{OBJECTS[kind](random)}}}\n"
        "tolerance: {height: 0.3 mm, size: 1 mm, force: 3 %}\n"
        f"conditions: {{stretch: {stretch:.1f} mm, depth: {random.uniform(*depth):.1f} mm, hold: 0.5 s, speed: 5 mm/s}}\n"
    )


def possible(text: str) -> list[str]:
    """Return the effects of membrane and object that a scene can have and that may change something in it."""
    scene = parse_scene(text)
    judged = judge(scene, Case(scene, scene.object.rough()))
    return [name for name, found in judged.items() if found.effect.group not in NOISE and found.sizes]


def with_effects(text: str, on: Collection[str]) -> str:
    """Return the text of a scene with these effects on, all others off, and without noise."""
    able = set(possible(text))
    noise = [name for name, effect in registry().items() if effect.group in NOISE]
    words = {name: "on" if name in on else "off" for name in registry() if name in able or name in noise}
    return f"{text}effects: {{{', '.join(f'{name}: {word}' for name, word in words.items())}}}\n"


def scene_with(text: str, on: Collection[str]) -> Scene:
    """Return the scene of `with_effects`."""
    return parse_scene(with_effects(text, on))


def pressed(scene: Scene, **how: Any) -> PressFigures:
    """Return the results of a press of a scene's conditions, straight down on its middle; `how` goes to the world. Raises NoEquilibrium."""
    began, use = time.process_time(), scene.conditions
    world, place = World(scene, **how), scene.object.position
    pose = Pose((place.x, place.y, scene.object.top - use.depth))
    contact = world.contact(pose, use.stretch)
    skin = world.skin(contact, use.stretch)
    spent = time.process_time() - began
    assert isinstance(skin, Grid)
    return seen(math.hypot(*contact.force), skin.points, use.depth - contact.drop, spent)


def solved(scene: Scene, settings: Settings) -> PressFigures:
    """Return the same of a rigid body by one solve of the sheet alone, without the presses beside it that the world draws its curve by."""
    began, use, world = time.process_time(), scene.conditions, World(scene)
    assert isinstance(world.fidelity, SheetFidelity)
    body, place = scene.object.body(), scene.object.position
    stands = Place(body, None, (place.x, place.y), -scene.object.heading, (0.0, 0.0), scene.object.reach, use.stretch)
    assert body is not None
    load = Load(turn(body, stands.heading), use.stretch, use.depth, stands.at, stands.tilt, world.fidelity.lift(stands))
    found = solve(world.fidelity.sheet, load, settings)
    spent = time.process_time() - began
    return seen(float(found.force[2]), found.points_outside(POINTS, POINTS), use.depth, spent)


def seen(force: float, grid: npt.NDArray[np.float64], depth: float, spent: float) -> PressFigures:
    """Return a press by the points (rows, columns, 3), m, of its membrane over an object that stands so deep in it, m."""
    points = grid.reshape(-1, 3)
    top = float(points[np.hypot(points[:, 0], points[:, 1]) < TOP, 2].mean())
    return PressFigures(force, top, _length(grid, HIGH * depth), spent)


def _length(grid: npt.NDArray[np.float64], level: float) -> float:
    """Return how far apart the middle line along y comes up through a level and goes down again, m; NaN where it does not."""
    line = grid[:, grid.shape[1] // 2]
    above = np.flatnonzero(line[:, 2] > level)
    if len(above) == 0 or above[0] == 0 or above[-1] == len(line) - 1:
        return math.nan
    ends = []
    for low, high in ((above[0] - 1, above[0]), (above[-1] + 1, above[-1])):
        part = (level - line[low, 2]) / (line[high, 2] - line[low, 2])
        ends.append(line[low, 1] + part * (line[high, 1] - line[low, 1]))
    return float(abs(ends[1] - ends[0]))


def apart(one: PressFigures, other: PressFigures) -> dict[str, float]:
    """Return how far a press is from another: part of the other's force, m of height and of size."""
    return {"force": one.force / other.force - 1, "height": one.height - other.height, "size": one.size - other.size}


@cache
def warm() -> None:
    """Load all that the first press of a process loads."""
    press_once(scene_with(drawn(np.random.default_rng(0), "sphere"), ("sag", "bending", "wrinkling", "friction")), 0)
