"""Scenes that nobody wants to meet: each ends with an answer that can be true, or with the reason why there is none."""

from __future__ import annotations

import math
from functools import partial

from stretch_bt.errors import InvalidInput, NoEquilibrium, SceneError
from stretch_bt.frames import Pose
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.scene import load_scene, parse_scene
from stretch_bt.simulation.world import World

HEAD = "format: stretch-scene/1\n"
BALL = "object: {type: sphere, diameter: 20 mm, rigid: true, base: 20 mm}\n"
SOFT = "object: {type: sphere, diameter: 60 mm, stiffness: 0.9 N/mm}\nfidelity: hertz\neffects: auto\n"
TWO = """\
object:
  type: several
  objects:
    - {type: sphere, diameter: 10 mm, rigid: true, position: {x: -10 mm}}
    - {type: sphere, diameter: 10 mm, rigid: true, position: {x: 10 mm}}
"""
TOP = 0.060
WIDE = "object: {type: box, length: 200 mm, width: 200 mm, height: 40 mm, rigid: true}\n"
BARE = "hand: {mount_prestretch: 0 mm}\n"


def _ball(law: str) -> str:
    return f"object: {{type: sphere, diameter: 40 mm, {law}}}\n"


def _balloon(pressure: str) -> str:
    return f"object: {{type: balloon, diameter: 60 mm, base: 30 mm, pressure: {pressure}, fill: {{type: water}}}}\n"


def _world(text: str) -> World:
    return World(parse_scene(HEAD + text))


def _truth(text: str, at: tuple[float, float, float], stretch: float = 0.0) -> dict[str, float]:
    return _world(text).truth(Pose(at), stretch)


def forces(low: float, high: float) -> Check:
    """Expect a force, N, in a truth whose numbers are all finite."""

    def check(truth: dict[str, float]) -> bool:
        return low <= truth["force"] <= high and all(math.isfinite(value) for value in truth.values())

    return Check(f"a force of {low:g} to {high:g} N, every truth finite", check)


def _series(truth: dict[str, float], travel: float) -> list[float]:
    """Return stiffness over 900 N/m, force over drop and stiffness, true over given travel, and sinking over drop, each less 1."""
    return [
        truth["stiffness"] / 900 - 1,
        truth["force"] / truth["deflection"] / truth["stiffness"] - 1,
        (truth["depth"] + truth["deflection"]) / travel - 1,
        (TOP - truth["height"]) / truth["deflection"] - 1,
    ]


def _consistent(fidelity: str, stretch: float, travel: float) -> list[float]:
    """Return how far the truth of a soft ball contradicts itself."""
    text = (
        f"object: {{type: sphere, diameter: 60 mm, stiffness: 0.9 N/mm}}\nfidelity: {fidelity}\neffects: {{sag: off}}\n"
    )
    return _series(_truth(text, (0.001, -0.002, TOP - travel), stretch), travel)


def _agree(within: float) -> Check:
    def check(off: list[float]) -> bool:
        return abs(off[1]) < within and max(abs(off[k]) for k in (0, 2, 3)) < 1e-6

    return Check(f"force over drop is the stiffness within {within:g}, all else within 1e-6", check)


def _after_refusal(pose: Pose, stretch: float) -> bool:
    """Whether a contact that was known is still the very same after one that is refused."""
    world, good = _world(SOFT), Pose((0, 0, TOP - 0.004))
    before = world.contact(good, 0.0)
    try:
        world.contact(pose, stretch)
    except NoEquilibrium:
        return world.contact(good, 0.0) is before
    return False


def _exchanged() -> World:
    """Return a world whose object is exchanged for one that its fidelity has no answer to."""
    world = _world(SOFT)
    world.exchange(_world("object: {type: cone, angle: 45 deg, height: 40 mm, rigid: true}\n").scene.object)
    return world


def _sagging() -> list[float]:
    """Return how far before the plane a hanging membrane touches, mm, its force half way there, and past it."""
    rigid = "object: {type: sphere, diameter: 60 mm, rigid: true}\nfidelity: sheet\neffects: {sag: on}\n"
    world = _world(rigid)
    lift = world.lift(Pose((0, 0, TOP)), 0.0)
    heights = (TOP + lift / 2, TOP + 1.01 * lift)
    return [lift * 1e3, *(world.contact(Pose((0, 0, z)), 0.0).force[2] for z in heights)]


def _told(text: str) -> str:
    """Return where and why a scene is refused."""
    try:
        parse_scene(HEAD + text)
    except SceneError as error:
        return "; ".join(f"{d.line}: {d.message}" for d in error.diagnostics)
    return "read"


#: the text of the scene, place of the hand, m, the stretch, m, and the expectation
ENDS = {
    "a ball smaller than a few pixels": (
        "object: {type: sphere, diameter: 5 mm, rigid: true, base: 20 mm}\n",
        (0.0, 0.0, 0.023),
        0.0,
        forces(0.01, 0.3),
    ),
    "wider than the membrane, in closed form": (
        "object: {type: plane, height: 40 mm, rigid: true}\nfidelity: hertz\n",
        (0.0, 0.0, 0.038),
        0.0,
        forces(0.1, 10.0),
    ),
    "at the free edge": (BALL, (0.044, 0.0, 0.035), 0.03, forces(0.04, 2.0)),
    "beside the membrane": (BALL, (0.2, 0.0, 0.03), 0.0, forces(0.0, 0.0)),
    "the hand deeper than the object is high": (BALL, (0.0, 0.0, 0.002), 0.0, forces(2.0, 30.0)),
    "hanging at stretch 0 without pre-stretch": (
        f"{BALL}{BARE}effects: {{sag: on}}\n",
        (0.0, 0.0, 0.036),
        0.0,
        forces(1e-3, 0.3),
    ),
    "two objects": (TWO, (0.0, 0.0, 0.006), 0.0, forces(0.05, 1.0)),
}
SOFTNESS = {
    "an object that gives way all the way down": (
        _ball("stiffness: 0.005 N/mm"),
        (0.0, 0.0, 0.001),
        0.08,
        forces(0.1, 0.2),
    ),
    "as good as infinitely stiff": (_ball("stiffness: 10000 N/mm"), (0.0, 0.0, 0.032), 0.0, forces(0.2, 2.0)),
    "as good as without stiffness": (_ball("stiffness: 0.001 N/mm"), (0.0, 0.0, 0.032), 0.0, forces(1e-6, 0.02)),
    "a balloon without pressure": (_balloon("0 kPa"), (0.0, 0.0, 0.055), 0.0, forces(0.0, 0.0)),
    "a balloon blown up hard": (_balloon("10 kPa"), (0.0, 0.0, 0.055), 0.0, forces(0.1, 1.0)),
}
REFUSED = {
    "wider than the membrane": (WIDE, (0.0, 0.0, 0.038), 0.0, "clamp"),
    "at the clamp": (BALL + BARE, (0.0, 0.049, 0.035), 0.0, "clamp"),
}
#: pose and stretch
UNKNOWN = {
    "a tilted hand": (Pose((0, 0, TOP - 0.005), (0.1, 0, 0)), 0.0, "tilted"),
    "beside the border": (Pose((0.05, 0, TOP - 0.005)), 0.0, "border"),
    "a stretch of 90 mm": (Pose((0, 0, TOP - 0.005)), 0.09, "stretch of 90 mm"),
    "a stretch below 0": (Pose((0, 0, TOP - 0.005)), -0.01, "stretch of -10 mm"),
}

CASES: tuple[Hard, ...] = (
    *group(
        "an object that is too small, too wide, at an edge, beside the membrane, or double",
        {name: (partial(_truth, text, at, x), expect) for name, (text, at, x, expect) in ENDS.items()},
        {
            name: (partial(_truth, text, at, x), Refusal(NoEquilibrium, said))
            for name, (text, at, x, said) in REFUSED.items()
        },
    ),
    *group(
        "an object gives way hardly at all, or by all of the hand's travel",
        {name: (partial(_truth, text, at, x), expect) for name, (text, at, x, expect) in SOFTNESS.items()},
        {
            f"a soft ball, {fidelity}, stretched by {1e3 * stretch:g} mm, {1e3 * travel:g} mm down": (
                partial(_consistent, fidelity, stretch, travel),
                _agree(1e-9 if fidelity == "hertz" else 2e-3),
            )
            for fidelity in ("hertz", "sheet")
            for stretch in (0.0, 0.03, 0.08)
            for travel in (1e-4, 0.005, 0.015)
        },
        costly=(
            "a soft ball, sheet, stretched by 0 mm, 0.1 mm down",
            "a soft ball, sheet, stretched by 0 mm, 15 mm down",
            "a soft ball, sheet, stretched by 30 mm, 15 mm down",
            "a soft ball, sheet, stretched by 80 mm, 0.1 mm down",
        ),
    ),
    *group(
        "a press without an answer at a fidelity must be refused, and leave the contact before as it was",
        {
            f"{name}, in closed form": (
                partial(lambda pose, x: _world(SOFT).contact(pose, x), pose, x),
                Refusal(NoEquilibrium, said),
            )
            for name, (pose, x, said) in UNKNOWN.items()
        },
        {
            f"{name}, and the contact before": (partial(_after_refusal, pose, x), Value(True))
            for name, (pose, x, _) in UNKNOWN.items()
        },
        {
            "a cone instead, in closed form": (
                _exchanged,
                Refusal(InvalidInput, "nothing stands in for a cone at hertz fidelity; use fidelity: sheet"),
            ),
        },
    ),
    *group(
        "a hanging membrane touches before its plane does",
        {
            "touched where it hangs": (
                _sagging,
                Check(
                    "0.2 to 1 mm before, lightly, and nothing past it",
                    lambda f: 0.2 < f[0] < 1 and 0 < f[1] < 0.05 and f[2] == 0,
                ),
            ),
        },
        {
            f"nothing touches above the top, {fidelity}": (
                partial(
                    _truth,
                    f"object: {{type: sphere, diameter: 60 mm, stiffness: 0.9 N/mm}}\nfidelity: {fidelity}\neffects: {{sag: off}}\n",
                    (0.0, 0.0, TOP),
                    0.02,
                ),
                Range(0.0, 0.0, of=lambda truth: truth["force"] + truth["depth"] + truth["deflection"]),
            )
            for fidelity in ("hertz", "sheet")
        },
    ),
    *group(
        "a scene may ask for what it cannot have, and the error must name the line",
        {
            "plasticity of a ball": (
                partial(_told, BALL + "effects:\n  sag: off\n  plasticity: on\n"),
                Check(
                    "line 5 is named", lambda told: told.startswith("5: ") and "a sphere cannot have plasticity" in told
                ),
            ),
            "viscosity of a ball": (
                partial(_told, BALL + "effects:\n  viscosity: {relaxation: 2 s}\n"),
                Check("line 4 is named", lambda told: told.startswith("4: ") and "viscosity" in told),
            ),
            "no object": (
                partial(_told, "fidelity: sheet\n"),
                Check("line 1 is named", lambda told: told.startswith("1: ") and "object is missing" in told),
            ),
        },
        {
            "a scene that is not shipped": (
                partial(load_scene, "water_ballon"),
                Refusal(SceneError, "no shipped scene.*water_balloon"),
            ),
        },
    ),
)
