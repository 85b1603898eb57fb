"""Dough in a scene: never touched, lost, pressed through, sticking to the hand, and led in long steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.hardcases.domains.dough.lumps import volume
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.hanging import Grip, pulled_by
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.objects.dough import DoughObject
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

WEIGHT = 0.1916  # N, of 25 mm of dough
STICKY = """\
format: stretch-scene/1
object: {type: dough}
hand: {frame: 12 mm}
tolerance: {roundness: 1 %, height: 0.5 mm}
conditions: {stretch: 60 mm, depth: 5 mm, hold: 0 s, speed: 30 mm/s, frames: 1, travel: 2 m}
"""
ROUND = [(0.045 * math.sin(k / 4), 0.036 * math.sin(k / 4) * math.cos(k / 4)) for k in range(50)]
USUAL: Mapping[str, Any] = {"points": ROUND, "height": 0.024, "step": 0.5, "directions": 500, "yield": 5.0}


def _world(options: Mapping[str, Any]) -> World:
    spec = DoughObject.model_validate(
        {
            "type": "dough",
            "directions": options["directions"],
            "yield_stress": f"{options['yield']} kPa",
            "modulus": f"{20 * options['yield']} kPa",
        }
    )
    return World(load_scene("dough_cube").with_(fidelity="hertz", object=spec))


def _led(**changes: Any) -> tuple[World, dict[str, float]]:
    """Lead the hand through points at a height; return the world, and the truth with the hand away."""
    options = {**USUAL, **changes}
    world, time = _world(options), 0.0
    for x, y in options["points"]:
        time += options["step"]
        world.advance(Pose((x, y, options["height"])), 0.06, time)
    return world, world.truth(Pose((0.0, 0.0, 0.09)), 0.06, time)


def _lump(world: World) -> Any:
    return world._past[-1].thing.lump


def _kept(found: tuple[World, dict[str, float]]) -> bool:
    world, truth = found
    lump = _lump(world)
    return all(math.isfinite(value) for value in truth.values()) and abs(volume(lump) / lump.volume - 1) < 1e-12


def _a_cube(found: tuple[World, dict[str, float]]) -> bool:
    return _kept(found) and abs(found[1]["radius_spread"] - 0.125) < 0.003


def _left_behind(found: tuple[World, dict[str, float]]) -> bool:
    world, _ = found
    half, reach = world.membrane.width / 2, world.scene.object.reach
    return _kept(found) and 0.02 < _lump(world).x < half + reach


def _longer_steps() -> dict[str, float]:
    """Return the truth after steps ten times as long less the truth after the usual ones."""
    usual, longer = (_led(step=step)[1] for step in (0.5, 5.0))
    return {name: longer[name] - value for name, value in usual.items()}


def _found_again() -> tuple[bool, bool, bool]:
    """Whether a lump rolled, stayed just as it was while the hand was above it, and rolled on."""
    world, time, lumps = World(load_scene("dough_cube").with_(fidelity="hertz")), 0.0, []
    for height in (0.024, 0.040, 0.024):
        for x, y in ROUND[:12]:
            time += 0.5
            world.advance(Pose((x, y, height)), 0.06, time)
        lumps.append(_lump(world))
    return lumps[0].steps > 0, lumps[1] is lumps[0], lumps[2].steps > lumps[0].steps


def _cut_elsewhere() -> float:
    """Return the change of the spread of radii where a path is given in four times as many steps."""
    spreads = []
    for parts in (1, 4):
        world, time, at = World(load_scene("dough_cube").with_(fidelity="hertz")), 0.0, (0.0, 0.0)
        for x, y in ROUND[:20]:
            for k in range(1, parts + 1):
                time, part = time + 0.5 / parts, k / parts
                world.advance(Pose((at[0] + part * (x - at[0]), at[1] + part * (y - at[1]), 0.024)), 0.06, time)
            at = (x, y)
        spreads.append(world.truth(Pose((0.0, 0.0, 0.09)), 0.06, 10.0)["radius_spread"])
    return spreads[1] - spreads[0]


def stuck(effects: str, stretch: float, *path: tuple[float, float]) -> tuple[World, Any, dict[str, float]]:
    """Lead a hand through (x, height), m, over a cube; return the world, and contact and truth at the end."""
    world, time, pose = World(parse_scene(f"{STICKY}effects: {{{effects}}}\n")), 0.0, Pose((0.0, 0.0, 0.1))
    for x, z in path:
        time, pose = time + 0.1, Pose((x, 0.0, z))
        world.advance(pose, stretch, time)
    return world, world.contact(pose, stretch, time), world.truth(pose, stretch, time)


def _raised(effects: str, stretch: float) -> Any:
    """Return whether the lump hangs, its place, top and pull, the membrane's lowest place, and the depth, 10 mm up and 20 mm on, m and N."""
    world, contact, truth = stuck(effects, stretch, (0.0, 0.024), (0.0, 0.035), (0.02, 0.035))
    lowest = _points(world.skin(contact, stretch))[..., 2].min()
    held = world.specimen.grip(world._past[-1].thing) is not None
    return held, _lump(world).x, truth["height"], contact.force[2], float(lowest), truth["depth"]


def _points(skin: Any) -> Any:
    return skin.points


def _comes_along(found: Any) -> bool:
    held, x, height, force, lowest, depth = found
    # its top is where the membrane is lowest, but for its bend
    under = abs(lowest - (height - 0.035)) < 2e-4
    return bool(held and depth == 0.0 and abs(force + WEIGHT) < 1e-3 and under and abs(x - 0.02) < 1e-6)


def _stays(found: Any) -> bool:
    held, _, height, force, lowest, depth = found
    return not held and depth == 0.0 and force == 0.0 and abs(height - 0.025) < 5e-4 and abs(lowest) < 1e-5


def _pulls() -> list[float]:
    return [stuck("tack: on", 0.0, (0.0, 0.024), (0.0, z))[1].force[2] for z in (0.0253, 0.0256, 0.0259, 0.030)]


def _put_down(*across: tuple[float, float]) -> bool:
    world, contact, truth = stuck("tack: {pull: 0.5 N}", 0.06, (0.0, 0.024), (0.0, 0.040), *across, (0.03, 0.023))
    low = np.array(world.sketch(world.latest)["side"])[:, 1].min()
    put = contact.force[2] > 0 and truth["height"] < 0.0255 and abs(low) < 1e-9
    return bool(put and abs(_lump(world).x - 0.03) < 1e-6)


def _sketched() -> tuple[float, float]:
    """Return how far the top of a sketch is off the height of a lump in the air, m, and how far its underside is above the table."""
    world, _, truth = stuck("tack: {pull: 0.5 N}", 0.06, (0.0, 0.024), (0.0, 0.040))
    side = np.array(world.sketch(world.latest)["side"])
    return float(side[:, 1].max() - truth["height"]), float(side[:, 1].min())


def _torn(way: float) -> Any:
    raise NoEquilibrium("torn")


def _untouched(force: float) -> bool:
    """Whether a hand that does not press leaves the very state that there was."""
    spec = DoughObject.model_validate({"type": "dough"})
    known = registry()
    thing = spec.specimen(Active(known[name](known[name].Parameters()) for name in ("plasticity", "springback")))
    state = thing.start()
    return thing.after(state, Moved(0.0, (0.0, 0.0, -force), (0.1, 0.0), 0.1, 5e-3)) is state


def _pressed_through() -> Any:
    spec = DoughObject.model_validate({"type": "dough"})
    thing = spec.specimen(Active([]))
    return thing.standing(thing.start(), 0.025)


#: effects and stretch
ALONG = {
    "on flour": ("tack: {pull: 0.25 N, hold: 0 N}", 0.0),
    "strong": ("tack: {pull: 0.5 N}", 0.0),
    "strong, under a tense membrane": ("tack: {pull: 0.5 N}", 0.06),
    "strong, under one that hangs": ("tack: {pull: 0.5 N}, sag: on", 0.0),
    "strong, under one that softens": ("tack: {pull: 0.5 N}, mullins: on", 0.02),
    "between two stretches that are solved": ("tack: {pull: 0.5 N}", 0.0437),
}
BEHIND = {
    "off": ("tack: off", 0.0),
    "as it is": ("tack: on", 0.0),
    "a table that holds it": ("tack: {pull: 0.25 N, hold: 0.1 N}", 0.0),
}
KEPT = Check("every truth finite, volume within 1e-12", _kept)
CUBE = Check("every truth finite, volume within 1e-12, and still a cube", _a_cube)

CASES: tuple[Hard, ...] = (
    *group(
        "the hand never touches the lump, loses it or moves in long steps, and the lump is coarse or fine",
        {
            "never touched": (partial(_led, height=0.040), CUBE),
            "it wanders off the membrane": (
                partial(_led, points=[(0.06 * k, 0.0) for k in range(6)]),
                Check("it stays behind, and is not rolled on by a hand that is past it", _left_behind),
            ),
            "led with 100 directions": (partial(_led, directions=100), KEPT),
            "led with 8000 directions": (partial(_led, directions=8000, points=ROUND[:8]), KEPT),
            "steps ten times as long": (
                _longer_steps,
                Check("every truth the same", lambda off: all(abs(value) < 1e-9 for value in off.values())),
            ),
            "lost on the way and found again": (_found_again, Value((True, True, True))),
            "a path cut elsewhere": (_cut_elsewhere, Value(0.0, abs=0.01)),
        },
    ),
    *group(
        "dough yields at hardly anything, never yields, or is pressed past its bulk yield",
        {
            "yields at hardly anything": (partial(_led, **{"yield": 0.4}), KEPT),
            "never yields": (partial(_led, **{"yield": 1e5}), CUBE),
            "past its bulk yield": (partial(_led, height=0.014), KEPT),
            "a drop of its height": (_pressed_through, Refusal(NoEquilibrium, "flat")),
            "a hand that does not press": (partial(_untouched, 0.0), Value(True)),
            "a hand that pulls": (partial(_untouched, -0.05), Value(True)),
            "a cube under the table": (
                partial(
                    parse_scene,
                    "format: stretch-scene/1\nobject: {type: dough, base: -5 mm}\ntolerance: {height: 1 mm}\n",
                ),
                Refusal(SceneError, "base"),
            ),
        },
    ),
    *group(
        "dough that sticks comes along where the hand holds it harder than table and weight",
        {
            f"sticky, {name}": (
                partial(_raised, *given),
                Check("it hangs under the hand, with its weight, and goes with it", _comes_along),
            )
            for name, given in ALONG.items()
        },
        {
            f"sticky, {name}": (partial(_raised, *given), Check("it stays on the table, without a force", _stays))
            for name, given in BEHIND.items()
        },
        {
            "a hand that rises": (
                _pulls,
                Check(
                    "pulls harder up to what the bond bears, then nothing",
                    lambda f: 0 > f[0] > f[1] > f[2] > -0.1 and f[3] == 0,
                ),
            ),
            "let go, and not touched again": (
                lambda: stuck("tack: on", 0.0, (0.0, 0.024), (0.0, 0.030), (0.0, 0.0255))[1].force,
                Value((0.0, 0.0, 0.0)),
            ),
            "put down after it was over the place": (partial(_put_down, (0.03, 0.040)), Value(True)),
            "put down in one step": (_put_down, Value(True)),
            "a sketch of it in the air": (_sketched, Value((0.0, 0.014), abs=5e-4)),
            "a membrane that has no answer": (
                partial(pulled_by, _torn, Grip(1.0, 0.1, 0.1, Cylinder(0.015)), 0.01),
                Refusal(NoEquilibrium, "torn"),
            ),
        },
        costly=(
            "sticky, strong, under a tense membrane",
            "sticky, strong, under one that hangs",
            "sticky, strong, under one that softens",
        ),
    ),
)
