"""Presses that break membrane solvers: slack, light, deep, sharp, at the edge, past the limit point, on a poor mesh."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardcases.expect import Check, Expectation, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation import PressResult, press
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.sheet.settings import Settings

USUAL: Mapping[str, Any] = {"indenter": "sphere:20mm", "stretch": 0.03, "depth": 0.010}
FINER = Settings(coarsen=0.7)


def pressed(**options: Any) -> PressResult:
    """Return the usual press, but for some options."""
    return press(**{**USUAL, **options})


@dataclass(frozen=True, slots=True)
class _Twice:
    """A press, and the same one on a finer mesh; it is the first that counts."""

    first: PressResult
    finer: PressResult

    @property
    def iterations(self) -> int:
        return self.first.iterations

    @property
    def residual(self) -> float:
        return self.first.residual


def _twice(**options: Any) -> _Twice:
    first = pressed(**options)
    return _Twice(first, pressed(**{**options, "mesh": None, "settings": FINER}))


def _balanced(found: PressResult) -> bool:
    numbers = found.force_error, found.residual, found.contact.area
    finite = all(value is not None and math.isfinite(value) for value in numbers)
    return found.force > 0 and found.balance < 1e-6 and finite


def _as_finer(found: _Twice) -> bool:
    error = found.first.force_error
    return error is not None and abs(found.finer.force - found.first.force) <= 3 * error


def answer(warns: str = "") -> Check:
    """Expect a balanced press within three of its stated errors of a finer mesh, with a warning or none of its mesh."""

    def check(found: _Twice) -> bool:
        told = any((warns or "mesh") in warning for warning in found.first.warnings)
        return _balanced(found.first) and _as_finer(found) and told == bool(warns)

    warned = f", a warning of a {warns}" if warns else ""
    return Check(f"balanced, within three of its errors of a finer mesh{warned}", check)


def refused(reason: str) -> Refusal:
    """Expect no equilibrium."""
    return Refusal(NoEquilibrium, reason)


def _rows(**rows: Any) -> dict[str, tuple[Callable[[], Any], Expectation]]:
    """Return presses with their expectations, each pressed twice where an answer is expected."""
    return {
        name: (partial(_twice if isinstance(expect, Check) else pressed, **options), expect)
        for name, (options, expect) in rows.items()
    }


ANSWER = answer()
SHARP = {"indenter": "cone:45deg", "depth": 0.005}
SMALL = {"indenter": "sphere:8mm", "stretch": 0.08}

SLACK = {
    "stretch exactly 0": ({"stretch": 0.0, "depth": 0.005}, ANSWER),
    "stretch 0, hardly touched": ({"stretch": 0.0, "depth": 0.2e-3}, answer("finer mesh")),
    "stretch 0, no compression": ({"stretch": 0.0, "depth": 0.005, "effects": ["wrinkling"]}, ANSWER),
    "stretch 0, hanging": ({"stretch": 0.0, "depth": 0.010, "effects": ["sag"]}, ANSWER),
    "stretch 0, flat cylinder": ({"stretch": 0.0, "depth": 0.005, "indenter": "cylinder:20mm"}, ANSWER),
    "stretch 0, 1 um": ({"stretch": 0.0, "depth": 1e-6}, refused("rounding")),
}
DEPTHS = {
    "1 um": ({"depth": 1e-6}, ANSWER),
    "15 mm in one step": ({"depth": 0.015}, ANSWER),
    "tip past its radius in one step": ({"indenter": "sphere:10mm", "stretch": 0.06, "depth": 0.015}, ANSWER),
    "past the limit point": ({**SMALL, "depth": 0.020}, refused("limit point")),
    "far past the limit point": ({**SMALL, "depth": 0.06}, refused("limit point")),
    "just before the limit point": ({"indenter": "sphere:8mm", "depth": 0.022}, ANSWER),
}
SHAPES = {
    "needle": ({"indenter": "sphere:0.5mm", "depth": 0.5e-3}, ANSWER),
    "needle, too deep": ({"indenter": "sphere:0.5mm", "depth": 0.005}, refused("limit point")),
    "flat cylinder": ({"indenter": "cylinder:20mm"}, ANSWER),
    "cone": (SHARP, ANSWER),
    "cone too sharp for its mesh": ({"indenter": "cone:80deg", "depth": 0.005}, refused("stands out")),
    "large face": ({"indenter": "cube:40mm"}, ANSWER),
    "wire deeper than it is thick": ({"indenter": Wire(0.0015, 0.2), "depth": 0.008}, ANSWER),
}
PLACES = {
    "tilted": ({"indenter": "cylinder:20mm", "tilt": (0.3, 0.1)}, ANSWER),
    "between two elements": ({"at": (0.7e-3, 0.4e-3)}, ANSWER),
    "half over the free edge": ({"indenter": "cone:45deg", "at": (0.037, 0.0), "depth": 0.006}, ANSWER),
    "over the free edge": ({"at": (0.040, 0.0)}, ANSWER),
    "at the free edge": ({"at": (0.036, 0.0)}, ANSWER),
    "beside the clamp": ({"at": (0.0, 0.055)}, ANSWER),
    "over the clamp": ({"at": (0.0, 0.060)}, refused("clamp")),
    "beside the sheet": ({"at": (0.2, 0.0)}, refused("does not reach")),
}
NUMBERS = {
    "modulus x 1e-6": ({"shear_modulus": 47.4e-3}, ANSWER),
    "modulus x 1e6": ({"shear_modulus": 47.4e9}, ANSWER),
    "mesh coarser than the contact": ({"mesh": 0.008, "depth": 0.002}, answer("finer mesh")),
    "little budget": ({"settings": Settings(budget=60)}, ANSWER),
    "no budget": ({"settings": Settings(budget=3)}, refused("iterations")),
}
#: place of a sphere of 20 mm pressed by 10 mm, and whether its shank overlaps a clamp: the clamps are at 65 mm, and it is
#: 10 mm thick to all sides at the height of the sheet
CLAMPS = {
    "10 mm short of a clamp": ((0.0, 0.055), False),
    "9 mm short of a clamp": ((0.0, 0.056), True),
    "5 mm short of a clamp, aside": ((0.03, -0.060), True),
    "10 mm past a clamp": ((0.0, 0.075), False),
    "past the corner of a clamp": ((0.054, 0.064), True),
}


#: place across of a sphere of 30 mm pressed by 4 mm, m, and least and largest error, as parts of the force
EDGES = {
    "off the edge": (0.0, (0.0, 0.004)),
    "beside the edge": (0.036, (0.005, 0.01)),
    "over the edge": (0.040, (0.01, 0.05)),
}


def _error_at(x: float) -> float:
    """Return the stated error of a press over its force."""
    found = pressed(indenter="sphere:30mm", depth=0.004, at=(x, 0.0))
    assert found.force_error is not None
    return found.force_error / found.force


def _refusal_at(at: tuple[float, float]) -> str:
    try:
        pressed(at=at)
    except NoEquilibrium as none:
        return none.reason
    return ""


#: stretch, depth, m, and force, N, of elements of 0.1 mm on a contact 64 times as stiff, of a cone of 45 degrees with a tip of 0.5 mm
TIPS = ((0.04, 0.0024, 0.1555), (0.04, 0.006, 0.4243), (0.0, 0.012, 0.5259))


def _tip(stretch: float, depth: float) -> float:
    """Return the force on a tip that is sharper than the sheet, which bends, is thick."""
    found = press("cone:45deg:0.5mm", stretch, depth, mount_prestretch=0.012, effects=["bending"])
    return found.force


def _overlaps(told: bool) -> Check:
    return Check(
        f"a clamp is {'named' if told else 'not named'} in a refusal", lambda reason: ("clamp" in reason) == told
    )


CASES: tuple[Hard, ...] = (
    *group(
        "an unstretched sheet has no stiffness across until it is pressed",
        _rows(**SLACK),
        costly=("stretch 0, flat cylinder", "stretch 0, hardly touched", "stretch 0, no compression"),
    ),
    *group(
        "forces near rounding, large steps, and a force that falls with depth",
        _rows(**DEPTHS),
        costly=("1 um", "past the limit point"),
    ),
    *group(
        "bodies thinner than a step, sharper than an element, or flat", _rows(**SHAPES), costly=("needle, too deep",)
    ),
    *group(
        "the contact begins off the mesh's middle, ends at an edge or a clamp, or is nowhere",
        _rows(**PLACES),
        costly=("half over the free edge",),
    ),
    *group(
        "a force near an edge of the sheet has a larger error: 0.5 % beside the edge, 1 % over it",
        {f"the error {name}": (partial(_error_at, x), Range(*ends)) for name, (x, ends) in EDGES.items()},
    ),
    *group(
        "the pressure of a plate gathers on a sharp tip, which sinks into a contact only as stiff as tension needs",
        {
            f"a tip {1e3 * depth:g} mm into a plate, stretch {1e3 * stretch:g} mm": (
                partial(_tip, stretch, depth),
                Value(force, rel=0.02),
            )
            for stretch, depth, force in TIPS
        },
    ),
    *group("moduli, meshes and budgets far from the usual ones", _rows(**NUMBERS), costly=("modulus x 1e-6",)),
    *group(
        "a shank that overlaps a clamp would be pressed through it",
        {name: (partial(_refusal_at, at), _overlaps(told)) for name, (at, told) in CLAMPS.items()},
    ),
)
