"""How far a membrane that resists bending stands above a flat top, against the law of `perception/drum.py`.

    python -m benchmarks.lift_off [--bodies 200] [--seed 0] [--fit]

Discs and blocks of 12 to 40 mm with edges of 0.5 to 10 mm are drawn, pressed 3 to 14 mm deep into the solved sheet, 1 and 2 mm thick, at
stretches of 0 to 60 mm. The lift is what the sheet stands above the middle of the face; errors are those of the law for the whole of it.
`--fit` prints the law that least squares of the logarithms gives of the draws.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception.drum import PART, lift_of_flat
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.threads import one_thread

GAUGE, WIDTH, MOUNT, SHEAR = 0.1, 0.09, 0.0119, 68.4e3  # m, Pa
THICK, STRETCHES = (1e-3, 2e-3), (0.0, 0.0, 0.01, 0.02, 0.04, 0.06)  # m


@dataclass(frozen=True)
class Drawn:
    """A press: half the size of the face, its depth, the membrane's thickness, m, and its strain; `lift`, m, is what came of it."""

    half: float
    depth: float
    thickness: float
    strain: float
    lift: float


def drawn(rng: np.random.Generator) -> Drawn:
    """Draw a press and solve it; raises NoEquilibrium."""
    edge = float(np.exp(rng.uniform(math.log(0.5e-3), math.log(10e-3))))
    first, second = rng.uniform(12e-3, 40e-3, 2).tolist()
    disc = rng.random() < 0.6
    side = first if disc else min(first, second)
    edge = min(edge, 0.4 * side)
    body = Cylinder(first, edge) if disc else Box(first, second, edge)
    stretch, depth, thickness = float(rng.choice(STRETCHES)), float(rng.uniform(3e-3, 14e-3)), float(rng.choice(THICK))
    sheet = Sheet(GAUGE, WIDTH, thickness, NeoHookean(SHEAR), MOUNT, Effects(sag=DENSITY, bending=True))
    press = solve(sheet, Load(body, stretch, depth, (0.0, 0.0), (0.0, 0.0)), Settings(exact=False, corrected=False))
    middle = press.shape.points(3, 3)[1, 1]
    half = 0.5 * (first if disc else math.sqrt(first * second))
    return Drawn(half, depth, thickness, (MOUNT + stretch) / GAUGE, float(middle[2]) - depth)


def by_law(press: Drawn) -> float:
    """Return the lift of a flat top by the law, m."""
    return lift_of_flat(press.depth, press.half, press.thickness, press.strain)


def main() -> None:
    """Print the errors of the law, in mm and over what it states."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fit", action="store_true")
    given = parser.parse_args()
    rng, presses, refused = np.random.default_rng(given.seed), list[Drawn](), 0
    with one_thread():
        for _ in range(given.bodies):
            try:
                presses.append(drawn(rng))
            except NoEquilibrium:
                refused += 1
    lift, law = np.array([p.lift for p in presses]), np.array([by_law(p) for p in presses])
    off = lift - law
    print(f"{len(presses)} presses, {refused} without an equilibrium; lift, mm: {_spread(lift)}")
    print(f"error, mm: rms {1e3 * np.sqrt(np.mean(off**2)):.3f}, most {1e3 * np.abs(off).max():.3f}")
    print(f"error over stated: rms {np.sqrt(np.mean((off / (PART * law)) ** 2)):.2f}")
    if given.fit:
        columns = [[1.0, *np.log([p.depth, p.thickness, p.strain, p.half])] for p in presses]
        fitted = np.linalg.lstsq(np.array(columns), np.log(np.maximum(lift, 1e-6)), rcond=None)[0]
        print(
            f"factor {math.exp(fitted[0]):.2f}; powers of depth, thickness, strain, half the size {fitted[1:].round(3)}"
        )


def _spread(values: np.ndarray) -> str:
    return ", ".join(f"{1e3 * v:.2f}" for v in np.percentile(values, [0, 10, 50, 90, 100]))


if __name__ == "__main__":
    main()
