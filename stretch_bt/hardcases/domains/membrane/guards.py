"""The guards of the sheet solver: steps through thin bodies, rounding, bodies that sank in, touches as light as rounding."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.simulation.effects.bending import Bending
from stretch_bt.simulation.effects.friction import Friction
from stretch_bt.simulation.effects.mullins import Softening
from stretch_bt.simulation.effects.sag import Sag
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.base import Zone
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.placed import place
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet.check import check
from stretch_bt.simulation.membrane.sheet.mesh import Mesh, breakpoints
from stretch_bt.simulation.membrane.sheet.newton import Minimum, Newton
from stretch_bt.simulation.membrane.sheet.problem import GRADIENT, ContactPenalty, Problem
from stretch_bt.simulation.membrane.sheet.spline import Axis
from stretch_bt.simulation.membrane.surface import pressed_surface
from stretch_bt.simulation.objects.base import HertzForm
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

SHEET: tuple[float, float, float, Any, float] = (0.090, 0.100, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH)
CONE, BALL = Cone(0.7854, 0.0005), Sphere(0.020)
SPAN = 0.045
FORMS = {
    "small sphere": HertzForm("sphere", 0.005),
    "sphere": HertzForm("sphere", 0.010),
    "large sphere": HertzForm("sphere", 0.030),
    "cylinder": HertzForm("cylinder", 0.010),
    "wide cylinder": HertzForm("cylinder", 0.030),
}


def problem_of(indenter: Any, depth: float) -> tuple[Problem, Any]:
    """Return a coarse problem of a press, and the flat sheet to start from."""
    zones = [Zone(-4.0, 4.0, 3.0)]
    mesh = Mesh(Axis(breakpoints(90.0, zones, 4.0)), Axis(breakpoints(100.0, zones, 4.0)))
    (body,) = place(indenter, (0.0, 0.0), (0.0, 0.0), depth)
    problem = Problem(mesh, np.array((0.5, 0.0, 1.0, 0.0, 0.0, 0.0)), [ContactPenalty(body, 2.0, 0.05)], 1e-3)
    flat = np.concatenate([mesh.rest * [0.95, 1.1], np.zeros((*mesh.shape[:2], 1))], axis=2)
    return problem, np.ascontiguousarray(flat)


def _longest_step(indenter: Any) -> float:
    """Return the longest of six steps from a shape far from balance over a quarter of the body's thickness."""
    problem, flat = problem_of(indenter, 0.006)
    flat[1:-1] += np.random.default_rng(0).normal(0, 1.0, flat[1:-1].shape)
    sizes: list[float] = []

    def done(step: Any) -> bool:
        sizes.append(step.size)
        return len(sizes) == 6

    Newton(problem, flat).run(done, 60)
    assert problem.largest_step is not None
    assert problem.largest_step <= indenter.bulk / 1e-3 / 4
    return max(sizes) / problem.largest_step


def _checked(depth: float) -> None:
    """Check a sheet that is flat, with a body up to a depth inside it."""
    problem, flat = problem_of(BALL, depth)
    outcome = Minimum(flat, problem.evaluate(flat, GRADIENT))
    assert outcome.evaluation.totals[0, 5] > 0  # points in contact
    sheet, load = SimpleNamespace(unit=1e-3), SimpleNamespace(travel=depth)
    check(_any(SimpleNamespace(force=np.array([0, 0, 1.0]), sheet=sheet, load=load)), problem, outcome)


def _any(given: Any) -> Any:
    return given


def _points(skin: Any) -> Any:
    return skin.points


def _collapsed() -> float:
    """Return the energy of a sheet of which a row of elements has no area."""
    problem, flat = problem_of(BALL, 0.006)
    flat[3, 3] = flat[8, 8] * 50
    flat[4] = flat[5] = flat[3]
    return float(problem.evaluate(flat, GRADIENT).energy)


def _grazed(body: Any, effects: tuple[Any, ...]) -> list[float]:
    sheet, there = _held(body, effects)
    top = _points(sheet.press(there, 1e-18, None).skin)[..., 2].max()
    assert abs(top) < 3e-5
    return [float(sheet.force(there, depth, None)[2]) for depth in (1e-18, 1e-9, 1e-6, 2e-5, 1e-4)]


def _held(body: Any, effects: tuple[Any, ...], at: tuple[float, float] = (0.0, 0.0)) -> tuple[SheetFidelity, Place]:
    return SheetFidelity(*SHEET, effects), Place(body, None, at, 0.0, (0.0, 0.0), 0.01, 0.0)


def _rising_from_nothing(forces: list[float]) -> bool:
    return forces == sorted(forces) and 0.0 <= forces[0] < 1e-15 and forces[-1] > 0


def _rising(forces: list[float]) -> bool:
    return forces == sorted(forces) and forces[0] > 0


def _just_met(*travels: float) -> list[float]:
    """Return forces under a tip that a bent, softened, hanging membrane just meets: energy is rounded by more than they change it."""
    effects: Any = [kind(kind.Parameters()) for kind in (Bending, Softening, Sag)]
    sheet, there = _held(CONE, effects)
    return [float(sheet.force(there, travel - sheet.lift(there), None)[2]) for travel in travels]


def _hanging(y: float) -> tuple[SheetFidelity, Place]:
    effects: Any = [Sag(Sag.Parameters())]
    return _held(BALL, effects, (0.0, y))


def _lift_over_hang(y: float) -> float:
    """Return how far before the plane a hanging membrane is met, less how far it hangs there, m."""
    sheet, there = _hanging(y)
    free = _points(sheet.free(0.0))
    near = np.hypot(*(free[..., :2] - np.array(there.at)).T).T.argmin()
    return float(sheet.lift(there) + free[..., 2].ravel()[near])


def _light_forces(y: float) -> list[float]:
    sheet, there = _hanging(y)
    law = sheet.law(there, None)
    return [law(travel - sheet.lift(there))[0] for travel in (1e-5, 1e-4, 2e-4, 3e-4, 5e-4, 1e-3)]


def _worst_shape(form: HertzForm) -> float:
    """Return the largest error of a closed shape's ends over the depth, for depths down to rounding."""
    worst = 0.0
    for depth in np.concatenate([np.geomspace(1e-19, 1e-2, 400), np.geomspace(6e-18, 8e-18, 50)]):
        surface = pressed_surface(form, float(depth), SPAN)
        rim = max(abs(float(surface.height(SPAN - 1e-12))) - 1e-12, 0.0)
        worst = max(worst, rim / depth, abs(float(surface.height(0.0)) / depth - 1))
    return worst


FRICTION: Any = (Friction(Friction.Parameters()),)
PLAIN: Any = ()

CASES = (
    *group(
        "a step longer than a body is thick takes the sheet to its other side",
        {
            "no step through a wire": (partial(_longest_step, Wire(0.001, 0.02)), Value(1.0, rel=1e-6)),
            "no step through a sphere": (partial(_longest_step, BALL), Value(1.0, rel=1e-6)),
        },
    ),
    *group(
        "a contact pressure that grows with depth lets a body sink in before it balances",
        {
            "a body that has sunk in": (partial(_checked, 0.006), Refusal(NoEquilibrium, "sinks through the sheet")),
            "a body that has hardly sunk in": (partial(_checked, 0.0002), Value(None)),
        },
    ),
    *group(
        "an element of no area has no strain",
        {"a collapsed element": (_collapsed, Value(float("inf")))},
    ),
    *group(
        "a force as small as rounding must go to nothing, and not to a refusal",
        {
            "grazing a sphere": (
                partial(_grazed, BALL, PLAIN),
                Check("forces rise from below 1e-15 N", _rising_from_nothing),
            ),
            "grazing a cone": (
                partial(_grazed, CONE, PLAIN),
                Check("forces rise from below 1e-15 N", _rising_from_nothing),
            ),
            "grazing a sphere with friction": (
                partial(_grazed, BALL, FRICTION),
                Check("forces rise from below 1e-15 N", _rising_from_nothing),
            ),
            "grazing a cone with friction": (
                partial(_grazed, CONE, FRICTION),
                Check("forces rise from below 1e-15 N", _rising_from_nothing),
            ),
            "a tip that a hanging membrane just meets": (
                partial(_just_met, 8e-5, 5e-4),
                Check("forces rise from above 0 N", _rising),
            ),
            "a tip that a hanging membrane just meets, in small steps": (
                partial(_just_met, 8e-5, 1.2e-4, 1.6e-4, 5e-4),
                Check("forces rise from above 0 N", _rising),
            ),
        },
        costly=(
            "grazing a cone",
            "grazing a sphere with friction",
            "grazing a cone with friction",
            "a tip that a hanging membrane just meets, in small steps",
        ),
    ),
    *group(
        "off its middle a membrane hangs less, and is met later",
        {
            f"hanging, {1e3 * y:g} mm off the middle, met where it hangs": (
                partial(_lift_over_hang, y),
                Value(0.0, abs=1e-5),
            )
            for y in (0.0, 0.020, 0.035)
        },
        {
            f"hanging, {1e3 * y:g} mm off the middle, light forces": (
                partial(_light_forces, y),
                Check("forces rise from above 0 N", _rising),
            )
            for y in (0.0, 0.020, 0.035)
        },
    ),
    *group(
        "the closed shape of a press has no solution past its limit point, and may cancel near depth 0",
        {
            f"closed shape, {name}, past the limit point": (
                partial(pressed_surface, form, 0.060, SPAN),
                Refusal(NoEquilibrium, "limit point"),
            )
            for name, form in FORMS.items()
        },
        {
            f"closed shape, {name}, down to 1e-19 m": (partial(_worst_shape, FORMS[name]), Range(0.0, 1e-6))
            for name in ("large sphere", "sphere", "cylinder")
        },
        {
            "closed shape, depth 0": (
                lambda: pressed_surface(FORMS["sphere"], 0.0, SPAN).height(np.array([0.0, 0.01, 0.1])),
                Value(np.zeros(3)),
            ),
        },
    ),
)
