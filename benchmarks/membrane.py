"""Accuracy and cost of the membrane solvers, each figure beside the one asked for.

    python -m benchmarks.membrane [open] [warm] [cold] [shapes]

Times are process CPU time of one thread, the smaller of two runs. Forces are compared with the same solver on elements
2.5 times finer; halving those again moves the force by less than 0.1 % under spheres.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from stretch_bt.errors import NoEquilibrium
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

FINE = Settings(coarsen=0.4)
WARM = {
    "3 %, 1.5 ms": Settings(exact=False, coarsen=2.2),
    "1 %, 4 ms": Settings(exact=False, coarsen=1.25),
    "0.3 %, 15 ms": Settings(exact=True, coarsen=0.9),
}
DEPTHS = range(1, 16)


def path(indenter: Indenter | Several, stretch: float, settings: Settings) -> list[PressResult]:
    """Return presses of 1 to 15 mm, each started from the last."""
    presses: list[PressResult] = []
    for depth in DEPTHS:
        start = presses[-1] if presses else None
        presses.append(press(indenter, stretch, depth * 1e-3, settings=settings, start=start))
    return presses


def timed_path(indenter: Indenter | Several, stretch: float, settings: Settings) -> tuple[Any, Any]:
    """Return forces (15,) and the smaller CPU ms of two runs (15,)."""
    runs = [path(indenter, stretch, settings) for _ in range(2)]
    return np.array([p.force for p in runs[0]]), np.min([[p.seconds * 1e3 for p in run] for run in runs], axis=0)


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
    print("warm 1 mm steps, sphere: median ms, worst ms, largest force error over 3 to 15 mm")
    for label, settings in WARM.items():
        medians, errors, worst = [], [], []
        for stretch in (0.01, 0.03, 0.06, 0.08):
            for diameter in (0.008, 0.02, 0.03):
                sphere = Sphere(diameter)
                forces, ms = timed_path(sphere, stretch, settings)
                reference = np.array([p.force for p in path(sphere, stretch, FINE)])
                medians.append(np.median(ms[1:]))
                worst.append(ms[1:].max())
                errors.append(np.abs(forces / reference - 1)[2:].max() * 100)
        print(
            f"  asked {label}: median {np.median(medians):.2f} ms (slowest case {max(medians):.2f}), "
            f"worst step {max(worst):.1f} ms, error {max(errors):.2f} % (median {np.median(errors):.2f} %)"
        )


def cold_presses() -> None:
    print("cold press from flat, sphere of 20 mm: ms (asked 40, 150 at stretch 0)")
    for stretch in (0.0, 0.01, 0.03, 0.08):
        ms = [min(press("sphere:20mm", stretch, d * 1e-3).seconds for _ in range(2)) * 1e3 for d in (2, 5, 10, 15)]
        print(f"  stretch {stretch * 1e3:.0f} mm: " + ", ".join(f"{v:.0f}" for v in ms))


def shapes() -> None:
    pair = Several((Part(Sphere(0.012), (-0.014, 0.0)), Part(Sphere(0.012), (0.014, 0.0))))
    cases: dict[str, Indenter | Several] = {
        "cylinder of 20 mm": Cylinder(0.02),
        "cone of 45 degrees": Cone(math.pi / 4),
        "cube face of 40 mm": Cube(0.04),
        "wire of 1.5 mm": Wire(0.0015, 0.2),
        "two spheres": pair,
    }
    print("other shapes at stretch 30 mm: warm ms, largest force error over 3 to 15 mm (asked 30 ms at 2 %)")
    for name, shape in cases.items():
        try:
            forces, ms = timed_path(shape, 0.03, Settings(exact=False))
            reference = np.array([p.force for p in path(shape, 0.03, Settings(coarsen=0.5))])
        except NoEquilibrium as none:
            print(f"  {name}: no equilibrium: {none.reason}")
            continue
        error = np.abs(forces / reference - 1)[2:].max() * 100
        print(f"  {name}: median {np.median(ms[1:]):.1f} ms, worst {ms[1:].max():.1f} ms, error {error:.2f} %")


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
