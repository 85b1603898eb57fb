"""Cost and error of the sheet solver, each figure beside the required one.

    python -m benchmarks.membrane [open] [warm] [cold] [shapes]

Times are process CPU time of one thread, the smallest of three runs. Forces are compared with exact presses on graded
elements of 0.5 mm that grow by 1.2, finer under a cone and a wire; `stretch-bt accuracy membrane` states their own error.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from stretch_bt.simulation.membrane.axisymmetric import CircularMembrane
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.several import Part, Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.press import PressResult, press
from stretch_bt.simulation.membrane.sheet.settings import Settings

WARM = {
    "at most 3 % in 1.5 ms": Settings.within(0.03),
    "at most 1 % in 4 ms": Settings.within(0.01),
    "at most 0.3 % in 15 ms": Settings.within(0.003),
}
RUNS = 3
DEPTHS = range(1, 16)


def path(indenter: Indenter | Several, stretch: float, settings: Settings) -> list[PressResult]:
    """Return presses of 1 to 15 mm, each started from the last."""
    presses: list[PressResult] = []
    for depth in DEPTHS:
        start = presses[-1] if presses else None
        presses.append(press(indenter, stretch, depth * 1e-3, settings=settings, start=start))
    return presses


def timed_path(indenter: Indenter | Several, stretch: float, settings: Settings) -> tuple[Any, Any]:
    """Return forces (15,) and the smallest CPU ms of the runs (15,)."""
    runs = [path(indenter, stretch, settings) for _ in range(RUNS)]
    return np.array([p.force for p in runs[0]]), np.min([[p.seconds * 1e3 for p in run] for run in runs], axis=0)


def errors(forces: Any, indenter: Indenter | Several, stretch: float, finest: float = 0.5e-3) -> Any:
    """Return the errors (13,), %, of forces (15,) at depths of 3 to 15 mm."""
    fine = path(indenter, stretch, Settings(mesh=finest, growth=1.2, budget=5000))
    return 100 * np.abs(forces / [p.force for p in fine] - 1)[2:]


def open_values() -> None:
    print("open values: relative error")
    for prestretch, depth, force in ((1.0, 0.3, 0.12680261), (1.2, 0.3, 0.54221102), (1.5, 0.6, 1.21905393)):
        membrane = CircularMembrane(1.0, 1.0, NeoHookean(1.0), prestretch)
        found = membrane.press(0.2, depth)
        step = 1e-3
        energies = [membrane.press(0.2, depth + k * step).energy for k in (-2, -1, 1, 2)]
        slope = float(np.dot([1, -8, 8, -1], energies)) / (12 * step) / found.force - 1
        print(f"  axisymmetric {prestretch} {depth}: {found.force / force - 1:+.1e}, dW/dd {slope:+.1e} (asked 1e-6)")
    for depth, value in ((0.005, 5.74), (0.010, 15.19), (0.015, 27.42)):
        found_sheet = press("sphere:20mm", 0.03, depth, shear_modulus=1e3)
        off = found_sheet.force * 1e3 / value - 1
        print(f"  sheet {depth * 1e3:.0f} mm: {off * 100:+.2f} % (asked 1 %, the value itself is good to 0.4 %)")


def warm_steps() -> None:
    print("warm 1 mm steps, spheres of 8, 20 and 30 mm at stretch 10, 30, 60 and 80 mm")
    for label, settings in WARM.items():
        ms, found = [], []
        for stretch in (0.01, 0.03, 0.06, 0.08):
            for diameter in (0.008, 0.02, 0.03):
                forces, times = timed_path(Sphere(diameter), stretch, settings)
                ms.append(times[1:])
                found.append(errors(forces, Sphere(diameter), stretch))
        medians = [float(np.median(times)) for times in ms]
        print(
            f"  asked {label}: median over the 14 steps {np.median(medians):.2f} ms (slowest case {max(medians):.2f}, "
            f"slowest step {np.max(ms):.1f}), largest error {np.max(found):.2f} % (p95 {np.percentile(found, 95):.2f} %)"
        )


def cold_presses() -> None:
    print("cold presses from flat at the default mesh, depths 2, 5, 10 and 15 mm: ms (asked 40, at stretch 0 150)")
    for shape in ("sphere:20mm", "cylinder:20mm", "cone:45deg"):
        for stretch in (0.0, 0.01, 0.03, 0.08):
            ms = [min(press(shape, stretch, d * 1e-3).seconds for _ in range(RUNS)) * 1e3 for d in (2, 5, 10, 15)]
            print(f"  {shape}, stretch {stretch * 1e3:.0f} mm: " + ", ".join(f"{v:.0f}" for v in ms))


def shapes() -> None:
    pair = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))
    cases: dict[str, tuple[Indenter | Several, float]] = {
        "cylinder of 20 mm": (Cylinder(0.02), 0.5e-3),
        "cone of 45 degrees": (Cone(math.pi / 4), 0.2e-3),
        "cube face of 40 mm": (Cube(0.04), 0.5e-3),
        "wire of 1.5 mm": (Wire(0.0015, 0.2), 0.3e-3),
        "two spheres of 12 mm": (pair, 0.5e-3),
    }
    print("other shapes at stretch 30 mm, Settings.within(0.01), warm 1 mm steps (asked 30 ms at 2 %)")
    for name, (shape, finest) in cases.items():
        forces, ms = timed_path(shape, 0.03, Settings.within(0.01))
        found = errors(forces, shape, 0.03, finest)
        print(
            f"  {name}: median {np.median(ms[1:]):.1f} ms, slowest {ms[1:].max():.1f}, largest error {found.max():.2f} %"
        )


PARTS: dict[str, Callable[[], None]] = {
    "open": open_values,
    "warm": warm_steps,
    "cold": cold_presses,
    "shapes": shapes,
}


def main() -> None:
    """Run the parts that are named, or all."""
    for name in sys.argv[1:] or PARTS:
        PARTS[name]()


if __name__ == "__main__":
    main()
