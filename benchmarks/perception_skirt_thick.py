"""Make the prior of a thick membrane's skirt: python benchmarks/perception_skirt_thick.py [FILE]

As `perception_skirt.py`, for the sheet as a hand holds it: it resists bending, so that it leaves a rim in a round of some 2 mm, and it
has none to all of its weight, because the correction of frames takes a part of the hang for an error of the camera. The mounts
stretch it by 9 to 15 mm at stretch 0; stretch here is the sum of both. Prints the residuals of the regression when each diameter is left out.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt
from perception_skirt import left_out, prior_from, row_of_view

from stretch_bt.accuracy.perception.view import BodyPress, seen_of
from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception.size import prior as prior_module
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.press import press
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects

Array = npt.NDArray[np.float64]

DIAMETERS = (8, 10, 12.5, 15, 17.5, 20, 22.5, 25, 27.5, 30, 34)
STRETCHES = (0, 7, 15, 30, 45, 60)
DEPTHS = (2, 3.5, 5, 7.5, 10, 12.5, 15)
OFF_CENTRE = 12  # mm, the range of places across and along
MOUNTED = (9, 15)  # mm, the range of what the mounts stretch by
FILE = Path(prior_module.__file__).with_name("skirt_thick.json")


def rows_of(
    diameter: float, stretch: float, at: tuple[float, float], mounted: float, weight: float
) -> list[list[float]]:
    """Return the rows of rising presses by one cylinder; lengths in mm, weight over the sheet's own. A press without equilibrium ends them."""
    found, last = [], None
    for depth in DEPTHS:
        wanted = BodyPress(Cylinder(diameter * 1e-3), stretch * 1e-3, depth * 1e-3, (at[0] * 1e-3, at[1] * 1e-3))
        try:
            last = press(
                wanted.indenter,
                wanted.stretch,
                wanted.depth,
                at=wanted.at,
                mount_prestretch=mounted * 1e-3,
                effects=Effects(sag=weight * DENSITY, bending=True),
                start=last,
            )
        except NoEquilibrium as error:
            print(f"{diameter:g} mm, stretch {stretch:g} mm, depth {depth:g} mm: {error}", file=sys.stderr)
            break
        row = row_of_view(seen_of(wanted, last.detail), replace(wanted, stretch=wanted.stretch + mounted * 1e-3))
        if row is not None:
            found.append(row)
    return found


def main() -> None:
    from scipy.stats import qmc

    file = Path(sys.argv[1]) if len(sys.argv) > 1 else FILE
    cases = list(product(DIAMETERS, STRETCHES))
    draws = qmc.Halton(4, scramble=False).random(len(cases) + 1)[1:]
    rows: list[list[float]] = []
    for (diameter, stretch), (u, v, w, weight) in zip(cases, draws, strict=True):
        at = (OFF_CENTRE * (u - 0.5), OFF_CENTRE * (v - 0.5))
        rows += rows_of(diameter, stretch, at, MOUNTED[0] + w * (MOUNTED[1] - MOUNTED[0]), weight)
        print(f"{diameter:g} mm, stretch {stretch:g} mm: {len(rows)} rows", file=sys.stderr, flush=True)
    table = np.array(rows)
    file.write_text(prior_from(table).to_json() + "\n", encoding="utf-8")
    sd = left_out(table)
    print(f"{len(rows)} presses; standard deviation of what the regression leaves, diameter left out")
    print(
        f"  ln ratio {sd[0]:.3f}, coefficients over the depth {'  '.join(f'{s:.3f}' for s in sd[1:8])}, radius {sd[8] * 1e3:.3f} mm"
    )
    print(f"written to {file}")


if __name__ == "__main__":
    main()
