"""Error of a felt force that is interpolated between solved presses, and its cost beside a solve of its own.

    python -m benchmarks.twin_curve

Depths of 0.1 to 15 mm drawn at random and taken on the way down, each against the sheet solved at that depth. `cost` is the CPU time of
all forces by the curve, with the presses that it solves, over the CPU time of a warm solve for each.
"""

from __future__ import annotations

import math
import time

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.effects.sag import Sag
from stretch_bt.simulation.fidelity.base import Place
from stretch_bt.simulation.fidelity.sheet import SheetFidelity
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet.result import Load, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

BODIES = ("sphere:10mm", "sphere:20mm", "sphere:60mm", "cylinder:20mm", "cone:60deg", "cube:20mm")
STRETCHES = (0.0, 0.02, 0.06)
DEPTHS = np.sort(np.random.default_rng(0).uniform(0.1e-3, 15e-3, 150))
MIDDLE, ASIDE, UPRIGHT = (0.0, 0.0), (0.0, 0.025), (0.0, 0.0)
CASES = (("no weight", (), MIDDLE), ("weight", (Sag(None),), MIDDLE), ("aside", (Sag(None),), ASIDE))
REACH = 0.03  # m


def main() -> None:
    """Print errors and costs by body, with and without the weight of the membrane, and with it 25 mm off its middle."""
    print("body           stretch  membrane   error above 1 mm: median    largest   below 1 mm: largest   cost  fails")
    worst = []
    for body in BODIES:
        for stretch in STRETCHES:
            for told, effects, at in CASES:
                error, cost, failed = compare(body, stretch, effects, at)
                deep, shallow = error[DEPTHS >= 1e-3], error[DEPTHS < 1e-3]
                worst.append(np.nanmax(deep))
                print(
                    f"{body:14s} {stretch * 1e3:4.0f} mm  {told:9s} {np.nanmedian(deep):25.4%} {worst[-1]:10.3%} "
                    f"{np.nanmax(shallow):21.2%} {cost:6.2f} {failed:6d}",
                    flush=True,
                )
    print(f"above 1 mm, all: median of the largest {np.median(worst):.3%}, largest {np.max(worst):.3%}")


def compare(
    body: str, stretch: float, effects: tuple[Sag, ...], at: tuple[float, float]
) -> tuple[np.ndarray, float, int]:
    """Return the error of each force by the curve, as a part of it, the cost of all, and for how many depths there is no solve."""
    indenter = parse_indenter(body)
    fidelity = SheetFidelity(0.09, 0.1, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, effects)
    place = Place(indenter, None, at, 0.0, UPRIGHT, REACH, stretch)
    law, hang, press, solved = fidelity.law(place, None), fidelity.lift(place), None, []
    began = time.process_time()
    for depth in DEPTHS:
        press = forced(fidelity, Load(indenter, stretch, float(depth), at, UPRIGHT, hang), press)
        solved.append(math.nan if press is None else press.force[2])
    between = time.process_time()
    felt = [
        law(float(depth))[0] if math.isfinite(force) else math.nan for depth, force in zip(DEPTHS, solved, strict=True)
    ]
    cost = (time.process_time() - between) / (between - began)
    return np.abs(np.array(felt) / np.array(solved) - 1), cost, int(np.isnan(solved).sum())


def forced(fidelity: SheetFidelity, load: Load, start: SheetPress | None) -> SheetPress | None:
    """Return a press, None where there is no equilibrium."""
    try:
        return solve(fidelity.sheet, load, Settings(), start)
    except NoEquilibrium:
        return None


if __name__ == "__main__":
    main()
