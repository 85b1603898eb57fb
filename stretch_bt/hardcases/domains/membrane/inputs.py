"""Arguments of a press that are no numbers, out of range, of another kind, or not for this solver."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.domains.membrane.presses import pressed
from stretch_bt.hardcases.expect import Check, Refusal
from stretch_bt.hardcases.hard import Hard, Rows, group
from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import MooneyRivlin, NeoHookean
from stretch_bt.simulation.membrane.round_sheet import RoundSheet
from stretch_bt.simulation.membrane.sheet.effects import Effects
from stretch_bt.simulation.membrane.sheet.settings import Settings

FAST = Settings(exact=False, coarsen=1.25)
RUBBER = NeoHookean(1.0)
#: radius, thickness and material 1
UNIT: dict[str, Any] = {"radius": 1.0, "thickness": 1.0, "material": RUBBER}

#: wrong options of a press by name, and a pattern of the refusal
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "depth 0": ({"depth": 0.0}, "above 0 m"),
    "depth NaN": ({"depth": math.nan}, "depth must be a finite number"),
    "stretch below 0": ({"stretch": -0.01}, "stretch must be a finite number of at least 0 m"),
    "stretch is a truth": ({"stretch": True}, "stretch must be a finite number"),
    "stretch is text": ({"stretch": "30mm"}, "stretch must be a finite number"),
    "stretch in millimetres": (
        {"stretch": 30},
        "stretch 30 m is more than 8 times the gauge, 0.1 m, .*; lengths are in m",
    ),
    "depth in millimetres": ({"depth": 10}, "depth 10 m is more than 2 times the gauge, 0.1 m, .*; lengths are in m"),
    "mount in millimetres": ({"mount_prestretch": 12}, "mount_prestretch 12 m is more than 8 times the gauge"),
    "a list of solvers": ({"solver": ["sheet"]}, "the solver must be one of"),
    "effects that are a number": ({"effects": 3}, "effects are a list of names, not"),
    "effects of numbers": ({"effects": [3]}, "effects are a list of names, not"),
    "an indenter that is a number": ({"indenter": 20}, "an indenter is a shape or text"),
    "an unknown solver": ({"solver": "fem"}, "the solver must be one of"),
    "a mesh below 0": ({"mesh": -0.002}, "mesh"),
    "a mesh of millions": ({"mesh": 1e-5}, "mesh|elements"),
    "a mesh that is text": ({"mesh": "2mm"}, "mesh must be a length .*, not '2mm'"),
    "mesh and settings": ({"mesh": 0.002, "settings": FAST}, "not both"),
    "settings of another kind": ({"settings": {"mesh": 0.002}}, "settings are Settings"),
    "a place of one number": ({"at": (0.0,)}, "two numbers each"),
    "a place that is a number": ({"at": 5}, "two numbers each"),
    "a place of texts": ({"at": ("a", "b")}, "two numbers each"),
    "gauge 0": ({"gauge": 0.0}, "gauge"),
    "gauge unknown": ({"gauge": None}, "gauge of a sheet .*, not None"),
    "width is text": ({"width": "90mm"}, "width of a sheet .*, not '90mm'"),
    "thickness is a list": ({"thickness": [0.002]}, "thickness of a sheet"),
    "mount is text": ({"mount_prestretch": "0mm"}, "mount pre-stretch .*, not '0mm'"),
    "modulus is text": ({"shear_modulus": "47kPa"}, "shear modulus .*, not '47kPa'"),
    "material is text": ({"material": "rubber"}, "a material is one of .*, not 'rubber'"),
    "an unknown effect": ({"effects": ["wrinkle"]}, "wrinkling"),
    "hertz, off the middle": ({"solver": "hertz", "at": (0.01, 0.0)}, "takes no at"),
    "hertz, another gauge": ({"solver": "hertz", "gauge": 0.075}, "membrane of the hand only"),
    "hertz, a cone": ({"solver": "hertz", "indenter": "cone:45deg"}, "a sphere or a cylinder"),
    "axisymmetric, a cube": ({"solver": "axisymmetric", "indenter": "cube:20mm"}, "a sphere only"),
}
SETTINGS: dict[str, Any] = {"NaN": math.nan, "below 0": -1, "text": "1", "0": 0}


def _settings() -> Iterator[Hard]:
    for name in ("budget", "growth", "coarsen", "mesh"):
        rows: Rows = {
            f"{name} {what}": (partial(Settings, **{name: v}), Refusal(InvalidInput, "must"))
            for what, v in SETTINGS.items()
        }
        yield from group("the solver loops over a setting or divides by it, so it must be a number above 0", rows)


def _round_presses() -> Iterator[Hard]:
    membrane = CircularMembrane(**UNIT)
    arguments = {
        "depth 0": (0.2, 0.0),
        "depth NaN": (0.2, math.nan),
        "wider than the rim": (1.5, 0.1),
        "radius 0": (0.0, 0.1),
    }
    rows: Rows = {name: (partial(membrane.press, *given), Refusal(InvalidInput)) for name, given in arguments.items()}
    yield from group("a round membrane is shot from its middle to its rim", rows, prefix="axisymmetric, ")


def _round_membranes() -> Iterator[Hard]:
    fields: dict[str, Any] = {
        "radius below 0": {"radius": -1.0},
        "slack": {"prestretch": 0.9},
        "infinitely thick": {"thickness": math.inf},
    }
    why = "a membrane that has no size, or is not taut"
    rows: Rows = {
        n: (partial(CircularMembrane, **{**UNIT, **given}), Refusal(InvalidInput)) for n, given in fields.items()
    }
    yield from group(why, rows, prefix="axisymmetric, ")
    fields |= {
        "radius NaN": {"radius": math.nan},
        "no thickness": {"thickness": 0.0},
        "stretched without end": {"prestretch": math.inf},
        "bending": {"effects": Effects(bending=True)},
    }
    del fields["infinitely thick"]
    rows = {n: (partial(RoundSheet, **{**UNIT, **given}), Refusal(InvalidInput)) for n, given in fields.items()}
    yield from group(why, rows, prefix="round sheet, ")


def _round_sheet() -> Iterator[Hard]:
    sheet, ball = RoundSheet(1.0, 1.0, RUBBER, 1.2), Sphere(0.4)
    presses: dict[str, tuple[Any, float]] = {
        "depth 0": (ball, 0.0),
        "depth NaN": (ball, math.nan),
        "text": ("sphere:20mm", 0.1),
    }
    rows: Rows = {name: (partial(sheet.press, *given), Refusal(InvalidInput)) for name, given in presses.items()}
    yield from group("an input that is no press", rows, prefix="round sheet, ")
    rows = {"past the limit point": (lambda: sheet.press(Sphere(0.2), 0.7), Refusal(NoEquilibrium))}
    yield from group("force that falls with depth has no equilibrium to find", rows, prefix="round sheet, ")


def _moduli() -> Iterator[Hard]:
    for bad in (0.0, -1.0, math.nan, math.inf):
        rows: Rows = {
            f"neo-Hookean, modulus {bad:g}": (partial(NeoHookean, bad), Refusal(InvalidInput)),
            f"Mooney-Rivlin, second invariant {bad or -0.1:g}": (
                partial(MooneyRivlin, 1.0, bad or -0.1),
                Refusal(InvalidInput),
            ),
        }
        yield from group("no material has such a modulus", rows)


def _past_the_limit_point() -> Iterator[Hard]:
    thin = CircularMembrane(1.0, 1.0, RUBBER, 1.2)
    rows: Rows = {"past the limit point": (lambda: thin.press(0.1, 0.6), Refusal(NoEquilibrium, "limit point|wraps"))}
    yield from group("force that falls with depth has no equilibrium to find", rows, prefix="axisymmetric, ")


def _unstated(found: Any) -> bool:
    return found.force > 0 and found.force_error is None and any("no error" in warning for warning in found.warnings)


CASES = (
    *group(
        "an argument that is no number, out of range, of another kind, or not for this solver",
        {name: (partial(pressed, **options), Refusal(InvalidInput, said)) for name, (options, said) in WRONG.items()},
    ),
    *group(
        "a model of the membrane with an unknown error of its own must not look exact",
        {
            f"{solver}, error not stated": (
                partial(pressed, solver=solver),
                Check("no error, and a warning that says so", _unstated),
            )
            for solver in ("hertz", "axisymmetric")
        },
    ),
    *_settings(),
    *_round_presses(),
    *_round_membranes(),
    *_past_the_limit_point(),
    *_round_sheet(),
    *_moduli(),
)
