"""Filled balloons of a scene: slack, hard, small, up to their rim, and with effects that their fill cannot have."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise
from typing import Any

from stretch_bt.errors import NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.effects import Active, registry
from stretch_bt.simulation.objects.balloon import SECANT_DROP, BalloonObject
from stretch_bt.simulation.objects.base import Moved
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

FILLS = ("air", "water", "pudding", "seeds")
PRESSURES = ("0.01 Pa", "2 Pa", "0.5 kPa", "2 kPa", "4 kPa", "10 kPa")
DIAMETERS = ("20 mm", "60 mm", "80 mm")
#: the most that a balloon of 20 mm may have
_SMALL = "3.7 kPa"


def _balloon(fill: str = "water", pressure: str = "4 kPa", diameter: str = "60 mm", **more: Any) -> BalloonObject:
    given = {"type": "balloon", "diameter": diameter, "base": "30 mm", "pressure": pressure, "fill": {"type": fill}}
    return BalloonObject.model_validate({**given, **more})


def _specimen(spec: BalloonObject, *names: str) -> Any:
    known = registry()
    return spec.specimen(Active(known[n](known[n].Parameters()) for n in known if n in ("compliance", *names)))


def _forces(fill: str, diameter: str) -> list[list[tuple[float, float]]]:
    """Return force and slope from above the top to the rim, for each pressure."""
    found = []
    for pressure in PRESSURES:
        hard = diameter == "20 mm" and pressure in ("4 kPa", "10 kPa")
        spec = _balloon(fill, _SMALL if hard else pressure, diameter)
        law = _specimen(spec, "gas_compressibility").response.law(None, 0.0)
        found.append([law(x * spec.radius) for x in (-0.1, 0.0, 1e-3, 0.01, 0.05, 0.2, 0.5, 0.99)])
    return found


def _rise_from_nothing(found: list[list[tuple[float, float]]]) -> bool:
    return all(
        forces[0] == forces[1] == (0.0, 0.0)
        and all(b[0] >= a[0] for a, b in pairwise(forces))
        and all(math.isfinite(f) and math.isfinite(k) and k >= 0 for f, k in forces)
        for forces in found
    )


def _slack(fill: str) -> tuple[Any, float]:
    """Return force and slope of a balloon without pressure after 5 mm, and by how much its top is then too high, m."""
    spec = _balloon(fill, "0 Pa")
    thing = _specimen(spec, "flattening", "latex_softening")
    force = (0.0, 0.0) if fill == "pudding" else thing.law(thing.start(), 0.0)(5e-3)  # whose gel stands by itself
    return *force, thing.standing(None, 5e-3).top - (spec.top - 5e-3)


def _standing(fill: str, drop: float, pressure: str = "4 kPa") -> Any:
    """Return the standing shape after a drop, given as a part of its limit, or of its radius without pressure."""
    spec = _balloon(fill, pressure)
    return _specimen(spec, "flattening", "latex_softening").standing(None, drop * spec.limit)


def _flattened(fill: str) -> list[float]:
    """Return whether the top keeps its shape without the effect, and its radius over the balloon's after 0, 0.5, 1.5 and 4 mm."""
    spec = _balloon(fill)
    kept, flat = _specimen(spec), _specimen(spec, "flattening")
    unchanged = float(kept.standing(None, SECANT_DROP).body == spec.body())
    return [unchanged, *(flat.standing(None, d).body.tip_radius / spec.radius for d in (0.0, 0.5e-3, 1.5e-3, 4e-3))]


def _flattens(found: list[float]) -> bool:
    unchanged, *radii = found
    return unchanged == 1.0 and radii[0] == 1.0 and radii == sorted(radii) and 1.05 < radii[2] < 1.4


def _secant_of(model: str) -> float:
    """Return the stiffness at 1.5 mm of a model over the stiffness of the table."""
    return _balloon(model=model).secant() / _balloon().secant()


def _past_the_limit() -> float:
    """Return the force of the solver's law past its limit over the force of a power law through it."""
    spec = _balloon(model="axisymmetric", elements=24)
    force, slope = spec.skin(spec.limit)
    return float(spec.skin(1.2 * spec.limit)[0] / (force * 1.2 ** (slope * spec.limit / force)))


def _pressed_seeds() -> tuple[float, tuple[float, ...], float]:
    thing = _specimen(_balloon("seeds"), "granular_hysteresis")
    pressed = thing.after(thing.start(), Moved(1.5e-3, (0.0, 0.0, -1.6), (0.0, 0.0), 1.0, 0.01))
    return thing.rest(pressed, 0.0), thing.kinks(pressed)[0], thing.memory


def _fast_pudding() -> float:
    """Return the force of a sudden press over the force at rest."""
    spec = _balloon("pudding")
    thing = _specimen(spec, "viscosity")
    return float(thing.law(thing.start(), 0.0)(SECANT_DROP)[0] / spec.law(SECANT_DROP)[0])


def _in_the_world(fill: str) -> tuple[float, float]:
    """Return the drop of a shipped balloon that may not give way, and of one with all effects, mm."""
    scene = load_scene(f"{fill}_balloon").with_(fidelity="hertz", effects="none")
    pose = Pose((0.0, 0.0, scene.object.top - 0.010))
    stiff, soft = (World(s).truth(pose, 0.0)["deflection"] for s in (scene, scene.with_(effects="all")))
    return 1e3 * stiff, 1e3 * soft


def _with_effect(fill: str, name: str) -> Any:
    return parse_scene(
        "format: stretch-scene/1\n"
        f"object: {{type: balloon, diameter: 60 mm, pressure: 4 kPa, fill: {{type: {fill}}}}}\n"
        f"effects:\n  {name}: on\n"
    )


IMPOSSIBLE = (
    ("water", "viscosity"),
    ("air", "granular_hysteresis"),
    ("seeds", "gas_compressibility"),
    ("seeds", "latex_softening"),
)
RISES = Check("force rises from 0, with a finite slope of at least 0", _rise_from_nothing)

CASES: tuple[Hard, ...] = (
    *group(
        "pressures from hardly any to the most, of balloons from 20 to 80 mm",
        {
            f"{fill}, {diameter}, any pressure": (partial(_forces, fill, diameter), RISES)
            for fill in FILLS
            for diameter in DIAMETERS
        },
    ),
    *group(
        "without pressure a skin has no tension, and a balloon may be pressed flat",
        {f"slack, {fill}": (partial(_slack, fill), Value((0.0, 0.0, 0.0), abs=1e-12)) for fill in FILLS},
        {f"slack and flat, {fill}": (partial(_standing, fill, 1.0, "0 Pa"), Refusal(NoEquilibrium)) for fill in FILLS},
        {
            "near the rim": (
                partial(_standing, "water", 0.99),
                Range(0.030, 0.060, of=lambda standing: standing.top),
            ),
            "past the rim": (partial(_standing, "water", 1.01), Refusal(NoEquilibrium, "rim")),
            "the solver past its limit": (_past_the_limit, Value(1.0, abs=1e-9)),
        },
    ),
    *group(
        "a top flattens by a force that its fill gives, and never to a plane",
        {
            f"a flattened top, {fill}": (
                partial(_flattened, fill),
                Check("flatter and flatter, by 5 to 40 % at 1.5 mm, where the effect is on", _flattens),
            )
            for fill in FILLS
        },
    ),
    *group(
        "each model of a skin must give the same stiffness at the drop that palpation asks for",
        {
            f"model {model}": (
                partial(_secant_of, model),
                Value(1.0, abs=0.005),
            )
            for model in ("linear", "table", "axisymmetric")
        },
    ),
    *group(
        "grains stay down, and a gel answers a sudden push harder",
        {
            "pressed seeds": (_pressed_seeds, Value((1.0e-3, 1.5e-3, math.inf), rel=1e-6)),
            "a sudden press of a pudding": (_fast_pudding, Range(1.2, 3.0)),
        },
        {
            f"in the world, {fill}": (
                partial(_in_the_world, fill),
                Check("gives way by 0.2 to 5 mm, or not at all", lambda d: d[0] == 0.0 and 0.2 < d[1] < 5),
            )
            for fill in FILLS
        },
    ),
    *group(
        "a scene must not promise an effect that the fill cannot have",
        {
            f"{fill} with {name}": (
                partial(_with_effect, fill, name),
                Refusal(SceneError, f":4:3 .*filled with {fill}"),
            )
            for fill, name in IMPOSSIBLE
        },
    ),
)
