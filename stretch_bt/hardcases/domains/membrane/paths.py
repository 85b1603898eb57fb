"""Presses that start from others: contact lost, other stretches, small steps and back, other meshes."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import Impossible, InvalidInput
from stretch_bt.hardcases.domains.membrane.presses import pressed
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.simulation import PressResult, press
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.settings import Settings

#: a small contact, of which a clamp pulled by 70 mm carries the mesh along
_PULLED: dict[str, Any] = {"indenter": "sphere:10mm", "depth": 0.008, "at": (0.0, 0.03)}


def _uneven() -> tuple[PressResult, PressResult]:
    """Return a press on elements of ten to one, and one on a finer mesh."""
    found = press("sphere:10mm", 0.03, 0.005, settings=Settings(growth=3.0))
    return found, press("sphere:10mm", 0.03, 0.005, settings=Settings(coarsen=0.5))


def _agree_on_uneven(found: tuple[PressResult, PressResult]) -> bool:
    first, finer = found
    mesh = _sheet(first).shape.mesh
    uneven = np.diff(mesh.y.breaks).max() > 10 * np.diff(mesh.x.breaks).min()
    return bool(uneven and first.force_error and abs(finer.force - first.force) <= 3 * first.force_error)


def _sheet(found: PressResult) -> Any:
    return found.detail


def _side_error() -> float:
    """Return the stated error of the side force, N, of a block and a ball of 16 mm side by side, off the middle."""
    both = Several((Part(Cube(0.016), (-0.014, 0.0)), Part(Sphere(0.016), (0.014, 0.0))))
    return float(_sheet(press(both, 0.03, 0.006, at=(0.004, 0.006))).side_error)


def _half_mesh(
    indenter: str, stretch: float, depth: float, at: tuple[float, float], tilt: tuple[float, float]
) -> float:
    """Return the force on half the mesh over that on the default one."""
    of: dict[str, Any] = {"at": at, "tilt": tilt}
    return (
        press(indenter, stretch, depth, settings=Settings(coarsen=0.5), **of).force
        / press(indenter, stretch, depth, **of).force
    )


def _lost_and_regained() -> PressResult:
    """Return the usual press after one with no point in common, which follows one without contact."""
    before = pressed()
    try:
        pressed(at=(0.2, 0.0), start=before)
    except Impossible:
        elsewhere = pressed(at=(-0.02, 0.03), depth=0.1e-3, start=before)
        return pressed(start=elsewhere)
    raise AssertionError("a press beside the sheet has no answer")


def _pulled(settings: Settings) -> float:
    """Return the ratio of a force after 70 mm of stretch to the force of a press of its own."""
    start = press(stretch=0.005, settings=settings, **_PULLED)
    found = press(stretch=0.075, settings=settings, start=start, **_PULLED)
    return found.force / press(stretch=0.075, **_PULLED).force


def _there_and_back() -> list[float]:
    """Return forces in steps to a depth over those at the same depths on the way back."""
    state, forces = None, []
    for depth in (*range(2, 13, 2), *range(10, 1, -2)):
        state = press("sphere:20mm", 0.03, depth * 1e-3, start=state)
        forces.append(state.force)
    return [there / back for there, back in zip(forces[:5], forces[:5:-1], strict=True)]


def _last_digit(indenter: str, stretch: float) -> list[PressResult]:
    """Return a press on the flat sheet, and those a last digit of the depth lower and higher."""
    return [press(indenter, stretch, 0.0041 * (1 + part)) for part in (0.0, -4e-16, 4e-16)]


def _one_answer(found: list[PressResult]) -> bool:
    forces = [one.force for one in found]
    return len({one.iterations for one in found}) == 1 and max(forces) - min(forces) < 1e-9 * max(forces)


def _shifted() -> list[float]:
    """Return forces over the first one where the indenter stands elsewhere in an element."""
    mesh = Settings(mesh=2e-3, growth=1.0)
    forces = [press("sphere:20mm", 0.03, 0.008, at=(x, 0.0), settings=mesh).force for x in (0.0, 0.5e-3, 1e-3)]
    return [force / forces[0] for force in forces]


def _warm_and_cold(first: float, **options: Any) -> tuple[PressResult, PressResult, bool]:
    """Return a press from another one, the same from nothing, and whether the one it started from is as it was."""
    start = pressed(depth=first)
    before = _sheet(start).shape.control.copy()
    warm = pressed(**options, start=start)
    return warm, pressed(**options), bool(np.array_equal(before, _sheet(start).shape.control))


def _ends_alike(found: tuple[PressResult, PressResult, bool]) -> bool:
    warm, cold, kept = found
    return kept and abs(warm.force / cold.force - 1) < 3e-3 and warm.iterations < cold.iterations + 5


ALIKE = Check("the force of a press from nothing within 0.3 %, as soon, and its start unchanged", _ends_alike)

CASES = (
    *group(
        "the shape that a press starts from does not touch where the next one does, or its mesh does not fit",
        {
            "elements of ten to one": (
                _uneven,
                Check("within three of its errors of a finer mesh", _agree_on_uneven),
            ),
            "contact lost and regained": (
                _lost_and_regained,
                Value(0.7193, rel=2e-3, of=lambda found: found.force),
            ),
            "a stretch carries the mesh along": (partial(_pulled, Settings()), Value(1.0, abs=0.01)),
            "a stretch carries a coarse mesh along": (partial(_pulled, Settings.within(0.01)), Value(1.0, abs=0.01)),
            "in small steps and back": (_there_and_back, Value([1.0] * 5, rel=1e-3)),
            "elsewhere in an element": (_shifted, Value([1.0] * 3, rel=0.01)),
        },
    ),
    *group(
        "beside a free edge a mesh twice as fine finds no way to the press from flat, as the edge folds round the indenter",
        {
            "a cone at the free edge, on half the mesh": (
                partial(_half_mesh, "cone:45deg", 0.0367, 0.0045, (-0.0382, 0.0023), (-0.2142, 0.2207)),
                Value(1.0, abs=0.03),
            ),
            "a cylinder at the free edge, on half the mesh": (
                partial(_half_mesh, "cylinder:14.4mm", 0.0663, 0.0126, (0.0331, 0.0422), (0.246, 0.217)),
                Value(1.0, abs=0.01),
            ),
        },
        costly=("a cylinder at the free edge, on half the mesh",),
    ),
    *group(
        "a flat face lies on the flat sheet from which a solve begins, and rounding would decide which points touch",
        {
            f"a last digit, {indenter}": (
                partial(_last_digit, indenter, stretch),
                Check("the same force within 1e-9 in as many iterations", _one_answer),
            )
            for indenter, stretch in (("cube:24mm", 0.01), ("cylinder:20mm", 0.04), ("cube:40mm", 0.04))
        },
    ),
    *group(
        "a ball beside a block does not make the side force of its face surer",
        {"a block and a ball, side force": (_side_error, Range(0.009, 0.012))},
    ),
    *group(
        "a press that starts from a deeper, shallower, shifted or slacker one ends as it does from nothing",
        {
            "warm, deeper": (partial(_warm_and_cold, 0.010, depth=0.011), ALIKE),
            "warm, sideways": (partial(_warm_and_cold, 0.010, at=(0.001, 0.002)), ALIKE),
            "warm, back": (partial(_warm_and_cold, 0.012), ALIKE),
            "a start from another sheet": (
                lambda: press("sphere:20mm", 0.03, 0.01, gauge=0.075, start=pressed()),
                Refusal(InvalidInput, "same sheet"),
            ),
            "a start that is no sheet": (
                lambda: pressed(start=press("sphere:20mm", 0.03, 0.01, solver="hertz")),
                Refusal(InvalidInput, "only a press by the sheet solver"),
            ),
        },
    ),
)
