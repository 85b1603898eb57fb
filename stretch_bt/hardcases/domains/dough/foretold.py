"""The effect of a scene's press and roll on its dough, in closed form, before anything is simulated."""

from __future__ import annotations

from typing import Any

from stretch_bt.hardcases.expect import Check, Range, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.dough.estimate import CUBE, Flow, flow
from stretch_bt.simulation.scene import load_scene


def _flow(springy: float) -> Flow:
    """Return the flow of the shipped cube, of a modulus of so many yield stresses."""
    scene = load_scene("dough_cube")
    cube: Any = scene.object
    spec = cube.model_copy(update={"modulus": springy * cube.yield_stress})
    return flow(Case(scene.with_(object=spec), spec.rough()))


CASES: tuple[Hard, ...] = (
    *group(
        "dough may spring back from all of a facet, or from none of it",
        {
            "usual dough keeps a part": (lambda: _flow(20.0).plastic, Range(0.4, 0.9)),
            "stiff dough keeps all": (lambda: _flow(1e6).plastic, Value(1.0, abs=1e-4)),
            "rubber keeps nothing, and no less": (lambda: _flow(0.2).plastic, Value(0.0)),
            "rounding grows with what stays": (
                lambda: [_flow(springy).rounding(_flow(springy).plastic) for springy in (0.2, 5.0, 20.0, 1e6)],
                Check(
                    "from 0 up, and less than a cube has",
                    lambda found: found[0] == 0 and found == sorted(found) and 0.05 < found[-1] < CUBE,
                ),
            ),
        },
    ),
)
