"""Presses with friction: none, hardly any, very much, over an edge, after a press that let go, on a ball that flattens."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.simulation import PressResult, press
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.effects import Effects, Mullins
from stretch_bt.simulation.membrane.sheet.increments import increments
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings

ROUND: dict[str, Any] = {"indenter": "sphere:20mm", "stretch": 0.03, "depth": 0.006}
ROUGH = Settings(coarsen=2.0)
BALL = Sphere(0.02)
EDGE: dict[str, Any] = {"indenter": "cone:45deg", "stretch": 0.03, "depth": 0.010, "at": (0.046, 0.0)}
PAIR = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))


def _rubbed(
    mu: float, *, start: PressResult | None = None, settings: Settings | None = None, **options: Any
) -> PressResult:
    return press(**{**ROUND, **options}, effects=Effects(friction=mu), start=start, settings=settings)


def _sheet(found: PressResult) -> Any:
    return found.detail


def _loads(found: PressResult) -> tuple[Any, Any, Any]:
    """Return the pressure and the size of the traction of each point in contact, and its area."""
    (held,) = _sheet(found).memory.frictions
    on = held.pressure > 0
    return held.pressure[on], np.linalg.norm(held.traction, axis=2)[on], held.weight[on]


def _extra(mu: float) -> float:
    """Return the force that friction adds to a press, as a part of it."""
    return _rubbed(mu).force / press(**ROUND).force - 1


def _of_no_friction() -> tuple[float, int]:
    """Return the largest traction of a press without friction, and how many points remember one."""
    found = _sheet(press(**ROUND))
    return float(np.abs(found.friction).max()), len(found.memory.frictions)


def _over_the_cone(mu: float = 0.3, **options: Any) -> float:
    """Return by how much tractions exceed mu times the pressure, as a part of that, over the contact."""
    pressure, size, area = _loads(_rubbed(mu, **{"depth": 0.005, **options}))
    return float(area @ np.maximum(size - mu * pressure, 0.0) / (area @ (mu * pressure)))


def _over_the_cone_dragged(depth: float) -> float:
    """Return the same of a press that was dragged by 1 mm."""
    return _over_the_cone(depth=depth, at=(0.001, 0.0), start=_rubbed(0.3, depth=depth))


def _slip(mu: float) -> float:
    """Return how far points near the middle of a contact slide while it is pressed by another 2 mm, sheet units."""
    before = _rubbed(mu, depth=0.004)
    places = [np.array([-1.5, 0.0, 1.5])] * 2
    first, last = (
        _sheet(found).shape.mesh.evaluate(_sheet(found).shape.control, *places)
        for found in (before, _rubbed(mu, start=before))
    )
    return float(np.abs(last - first)[..., :2].max())


def _in_many_increments() -> float:
    """Return the force of a press led down in steps of 0.5 mm over the force of a press led down in one call."""
    state = None
    for depth in np.arange(1, 17) * 0.5e-3:
        state = _rubbed(0.5, depth=float(depth), start=state, settings=ROUGH)
    assert state is not None
    return state.force / _rubbed(0.5, depth=0.008, settings=ROUGH).force


def _mirrored(sx: int, sy: int) -> float:
    options: dict[str, Any] = {"depth": 0.004, "settings": ROUGH}
    base = _rubbed(0.4, at=(0.011, 0.007), **options)
    return _rubbed(0.4, at=(sx * 0.011, sy * 0.007), **options).force / base.force


def _scaled() -> float:
    """Return the force of a press ten times as large of rubber a million times as stiff, over what it should be."""
    base = _rubbed(0.4, depth=0.004, at=(0.011, 0.007), settings=ROUGH)
    big: dict[str, Any] = {
        "indenter": Sphere(0.2),
        "stretch": 0.3,
        "depth": 0.04,
        "at": (0.11, 0.07),
        "settings": ROUGH,
    }
    scaled = _rubbed(0.4, **big, gauge=1.0, width=0.9, thickness=0.02, shear_modulus=47.4e9)
    return scaled.force / (1e8 * base.force)


def _fast_over_exact() -> tuple[float, float]:
    """Return the ratios of forces of settled and exact presses, straight down and dragged from there."""
    fast, exact = (_rubbed(0.5, at=(0.004, 0.0), settings=Settings(exact=e)) for e in (False, True))
    dragged = [
        float(_sheet(_rubbed(0.5, at=(0.009, 0.0), start=s, settings=Settings(exact=e))).friction[0])
        for s, e in ((fast, False), (exact, True))
    ]
    return fast.force / exact.force, dragged[0] / dragged[1]


def _let_go(body: str) -> float:
    """Return the force of a press where a deeper one let go, over the force on a new membrane: softened, and not dragged."""
    both: dict[str, Any] = {"effects": Effects(friction=0.3, mullins=Mullins()), "stretch": 0.01, "settings": ROUGH}
    loose = _sheet(press("sphere:20mm", depth=0.012, **both)).let_go()
    assert loose.let_go() is loose
    return press(body, depth=0.006, start=loose, **both).force / press(body, depth=0.006, **both).force


def _on_another() -> PressResult:
    both: dict[str, Any] = {"effects": Effects(friction=0.3, mullins=Mullins()), "stretch": 0.01, "settings": ROUGH}
    return press("cone:45deg", depth=0.006, start=press("sphere:20mm", depth=0.012, **both), **both)


def _flattened() -> float:
    """Return by how much tractions differ on a ball that grew by 2 % on the way, as a part of them."""
    first = _rubbed(0.3, at=(-0.005, 0.0))
    same, flatter = (
        _sheet(_rubbed(0.3, indenter=f"sphere:{d}mm", at=(0.0, 0.0), start=first)).friction for d in (20, 20.4)
    )
    return float(np.abs(flatter - same).max() / np.linalg.norm(same))


def _on_its_own_mesh() -> list[float]:
    """Return by how much the tractions of a memory differ on its own mesh, and on a mesh like it."""
    found = _sheet(_rubbed(0.3, settings=ROUGH))
    (held,), mesh = found.memory.frictions, found.shape.mesh
    moved = [held.on(mesh, other) for other in (mesh, replace(mesh))]
    return [float(np.abs(other.traction - held.traction).max()) for other in moved]


def _dragged() -> list[tuple[float, float]]:
    """Return force along the way and along z of a sphere 10 mm further on, at its middle, and 10 mm back, at its middle."""
    state, met = _rubbed(0.3, at=(-0.005, 0.0), settings=ROUGH), []
    for x in (*range(-4, 6), *range(4, -5, -1)):
        state = _rubbed(0.3, at=(x * 1e-3, 0.0), start=state, settings=ROUGH)
        if x == 0:
            met.append((float(_sheet(state).force[0]), state.force))
    return met


def _drag_reverses(met: list[tuple[float, float]]) -> bool:
    (ahead, load), (behind, other) = met
    return abs((ahead - behind) / (load + other) - 0.3) < 0.045 and abs(ahead + behind) < 0.05 * abs(ahead)


def _steps(start: Load | None, load: Load) -> tuple[int, float, bool]:
    """Return how many increments lead to a load, the longest over its limit, and whether the last is exact."""
    loads = list(increments(start, load, 1e-3))
    limits = np.array([1e-3, 1e-3, 1e-3, 1e-3, 0.05, 0.05])
    moves = [(b.moves() - a.moves()) / limits for a, b in pairwise([start or load.part(0.0), *loads])]
    return len(loads), float(np.abs(moves).max()), loads[-1] == load


OFF = Load(BALL, 0.03, 0.0052, (0.01, 0.0), (0.1, 0.0))

CASES = (
    *group(
        "a coefficient that is no number, or below 0",
        {
            f"coefficient {mu:g}": (partial(Effects, friction=mu), Refusal(InvalidInput, "friction"))
            for mu in (-0.1, math.nan, math.inf)
        },
        {"the usual coefficient": (lambda: Effects.named(["friction"]).friction, Value(0.5))},
    ),
    *group(
        "with hardly any friction the springs of the contact slide at once; with much they never do",
        {
            "no friction": (_of_no_friction, Value((0.0, 0))),
            "hardly any friction": (partial(_extra, 1e-6), Value(0.0, abs=1e-4)),
            "little friction": (partial(_extra, 0.1), Range(1e-3, 0.015)),
            "usual friction": (partial(_extra, 0.4), Range(0.01, 0.05)),
            "much friction holds points": (lambda: _slip(20.0) / _slip(1e-6), Range(0.0, 0.1)),
        },
    ),
    *group(
        "no traction exceeds mu times the pressure, but the solver has only the pressure of the solve before",
        {
            "the cone holds under a sphere": (_over_the_cone, Range(0.0, 2e-3)),
            "the cone holds under a rim": (partial(_over_the_cone, indenter="cylinder:20mm"), Range(0.0, 2e-3)),
            "the cone holds with little friction": (partial(_over_the_cone, 0.02), Range(0.0, 2e-3)),
            "the cone holds under a light touch that is dragged": (
                partial(_over_the_cone_dragged, 0.5e-3),
                Range(0.0, 2e-3),
            ),
        },
    ),
    *group(
        "tractions count in the balance of forces, also aside, tilted and under two bodies",
        {
            "aside and tilted": (
                partial(_rubbed, 0.5, at=(0.012, 0.009), tilt=(0.1, 0.0)),
                Check(
                    "forces in balance within 1e-6, and the sheet held up",
                    lambda found: (
                        found.balance < 1e-6
                        and np.linalg.norm(found.detail.force + found.detail.reaction) < 1e-6 * found.force
                        and found.detail.friction[2] > 0
                    ),
                ),
            ),
            "two bodies": (
                partial(_rubbed, 0.5, indenter=PAIR),
                Check(
                    "in balance within 1e-6, and nothing across",
                    lambda found: found.balance < 1e-6 and abs(found.detail.friction[0]) < 1e-6 * found.force,
                ),
            ),
        },
    ),
    *group(
        "the end depends on the path, but not on how finely the path is divided, nor on mirror images or scale",
        {
            "in many increments": (_in_many_increments, Value(1.0, abs=1e-3)),
            "mirrored across": (partial(_mirrored, -1, 1), Value(1.0, abs=1e-8)),
            "mirrored along": (partial(_mirrored, 1, -1), Value(1.0, abs=1e-8)),
            "ten times as large, a million times as stiff": (_scaled, Value(1.0, abs=1e-8)),
            "settled instead of exact": (_fast_over_exact, Value((1.0, 1.0), abs=0.03)),
            "dragged there and back": (_dragged, Check("0.3 of the load both ways, within 15 %", _drag_reverses)),
        },
    ),
    *group(
        "a path goes on from where it was, from first contact, or from nothing",
        {
            "over the free edge": (
                lambda: press(**EDGE, effects=Effects(friction=0.3)).force / press(**EDGE).force,
                Value(1.0, abs=0.2),
            ),
            "from a press without friction": (
                lambda: press(**ROUND, effects=Effects(friction=0.3), start=press(**ROUND)),
                Refusal(InvalidInput, "same sheet"),
            ),
            "from another indenter": (
                lambda: _rubbed(0.3, indenter="cone:45deg", start=_rubbed(0.3)),
                Refusal(InvalidInput, "same indenter"),
            ),
            "from another indenter that is pressed in": (_on_another, Refusal(InvalidInput, "let_go")),
            "after it let go": (partial(_let_go, "sphere:20mm"), Range(0.5, 0.99)),
            "after it let go of another ball": (partial(_let_go, "sphere:22mm"), Range(0.5, 0.99)),
            "under a ball that flattens": (_flattened, Range(0.0, 0.05)),
        },
    ),
    *group(
        "each increment hands its tractions on, unchanged where the mesh stays the same",
        {"a memory on its own mesh": (_on_its_own_mesh, Value([0.0, 0.0]))},
    ),
    *group(
        "a path is divided into moves of at most a sheet unit, and ends exactly",
        {
            "a path from first contact": (partial(_steps, None, OFF), Value((6, 0.0052 / 6e-3, 1), abs=1e-9)),
            "a path of a micrometre": (
                lambda: _steps(None, Load(BALL, 0.0, 1e-6, (0.0, 0.0), (0.0, 0.0)))[0],
                Value(4),
            ),
            "a path across": (
                partial(_steps, Load(BALL, 0.03, 0.0052, (0.0, 0.0), (0.1, 0.0)), OFF),
                Value((10, 1.0, 1), abs=1e-9),
            ),
            "a path to where it is": (partial(_steps, OFF, OFF), Value((1, 0.0, 1), abs=1e-9)),
        },
    ),
)
