"""Random scenes to press, and what a press of one gives with some effects on and all others off: shared by benchmarks of the advisor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Pose
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import NOISE, judge
from stretch_bt.simulation.camera.skin import Grid
from stretch_bt.simulation.effects import registry
from stretch_bt.simulation.scene import Scene, parse_scene
from stretch_bt.simulation.world import World

TOP, HIGH = 2e-3, 0.8  # m round the middle that counts as top, and share of the depth at which a length is taken

Item, Result = TypeVar("Item"), TypeVar("Result")


class Press(NamedTuple):
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
    "cone": lambda r: f"type: cone, angle: {r.uniform(15, 55):.1f} deg, height: 60 mm, tip: {_log(r, 0.5, 8):.2f} mm, rigid: true",
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
    "wire_circle": lambda r: f"type: wire_circle, diameter: {r.uniform(30, 60):.1f} mm, thickness: {r.uniform(1.5, 4):.1f} mm, base: 20 mm",
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
    """Return the effects of membrane and object that a scene can have."""
    scene = parse_scene(text)
    judged = judge(scene, Case(scene, scene.object.rough()))
    return [name for name, found in judged.items() if found.effect.group not in NOISE]


def with_effects(text: str, on: Collection[str], given: str = "") -> str:
    """Return the text of a scene with these effects on, all others off, and without noise; `given` are further choices, as in a scene file."""
    able = set(possible(text))
    words = {name: "on" if name in on else "off" for name, e in registry().items() if name in able or e.group in NOISE}
    listed = ", ".join([given] * bool(given) + [f"{n}: {w}" for n, w in words.items() if f"{n}:" not in given])
    return f"{text}effects: {{{listed}}}\n"


def scene_with(text: str, on: Collection[str], given: str = "") -> Scene:
    """Return the scene of `with_effects`."""
    return parse_scene(with_effects(text, on, given))


def pressed(scene: Scene, **how: Any) -> Press:
    """Return what a press of a scene's conditions gives, straight down on its middle; `how` goes to the world. Raises NoEquilibrium."""
    began, use = time.process_time(), scene.conditions
    world, place = World(scene, **how), scene.object.position
    pose = Pose((place.x, place.y, scene.object.top - use.depth))
    contact = world.contact(pose, use.stretch)
    skin = world.skin(contact, use.stretch)
    spent = time.process_time() - began
    assert isinstance(skin, Grid)
    points = skin.points.reshape(-1, 3)
    top = float(points[np.hypot(points[:, 0], points[:, 1]) < TOP, 2].mean())
    return Press(math.hypot(*contact.force), top, _length(skin.points, HIGH * (use.depth - contact.drop)), spent)


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


def apart(one: Press, other: Press) -> dict[str, float]:
    """Return how far a press is from another: part of the other's force, m of height and of size."""
    return {"force": one.force / other.force - 1, "height": one.height - other.height, "size": one.size - other.size}


def shared(work: Callable[[Item], Result], items: Sequence[Item], jobs: int) -> Iterable[Result]:
    """Yield what some work makes of each item, in their order, on several processes of one thread each."""
    if jobs == 1:
        yield from map(work, items)
        return
    from joblib import Parallel, delayed

    yield from Parallel(n_jobs=jobs, return_as="generator", batch_size=1)(delayed(work)(item) for item in items)
