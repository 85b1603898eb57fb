"""Rolling and pressing dough: results beside known figures, and CPU time; run as `python benchmarks/dough.py`.

The known figures are of a separate code of the same model. `stretch-bt accuracy dough` measures what directions cost and give, and
paths and spin beside that code.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.dough.rolling import roll, tumbled
from stretch_bt.simulation.coupling import couple
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance
from stretch_bt.simulation.dough.surface import upper_side
from stretch_bt.simulation.membrane.press import press

Array = npt.NDArray[np.float64]

RULE = 1e-3  # m; the height rule: ten readings, one a revolution apart, with a smaller standard deviation
FORCES = {
    10: ((0.106, 0.102, 0.099), (0.095, 0.088, 0.082), (0.075, 0.060, 0.049), (0.053, 0.034, 0.018)),
    20: ((0.089, 0.076, 0.059), (0.066, 0.043, 0.022), (0.041, 0.028, 0.025), (0.038, 0.037, 0.036)),
    30: ((0.078, 0.058, 0.034), (0.053, 0.030, 0.022), (0.038, 0.035, 0.034), (0.045, 0.047, 0.048)),
}
# directions, force N, yield stress Pa, modulus over it, spin: revolutions until the rule, roundness after 200
LONG = {
    (500, 1.0, 5e3, 20, 0.5): (23, 0.019),
    (2000, 1.0, 5e3, 20, 0.5): (20, 0.017),
    (2000, 1.0, 5e3, 20, 0.0): (24, 0.092),
    (2000, 2.0, 10e3, 10, 0.5): (32, 0.082),
    (2000, 2.0, 10e3, 30, 0.5): (17, 0.031),
    (2000, 1.0, 10e3, 10, 0.1): (None, 0.111),
    (2000, 3.0, 10e3, 10, 0.5): (20, 0.036),
}


def forces() -> None:
    print("\nroundness after 1, 2, 4 m of a figure-eight, spin 0.1, edge 25 mm, 8 lumps, beside the known one")
    print("E/Y  F / (Y R^2) " + "".join(f"{group:>28.2f}" for group in (0.5, 0.83, 1.2, 1.5)))
    for ratio, known in FORCES.items():
        cells = []
        for group, figures in zip((0.5, 0.83, 1.2, 1.5), known, strict=True):
            rows = []
            for seed in range(8):
                lump = tumbled(0.025, 500, seed)
                rows.append(
                    roll(
                        lump, "eight", [1.0, 2.0, 4.0], Dough(5e3, ratio * 5e3), group * 5e3 * lump.ball**2, 0.1, seed
                    )[0]
                )
            found = np.median(rows, axis=0)
            cells.append(" ".join(f"{a:.3f}/{b:.3f}".replace("0.", ".") for a, b in zip(found, figures, strict=True)))
        print(f"{ratio:3d}              " + "   ".join(cells))


def stopped(heights: Array) -> int | None:
    """Return the revolutions after which ten readings, one a revolution, spread by less than the rule."""
    readings = heights[::60]
    for last in range(10, len(readings)):
        if readings[last - 10 : last].std() < RULE:
            return last
    return None


def long() -> None:
    print(
        "\n200 revolutions on a circle: the height rule first holds, roundness then, and CPU time, beside the known ones"
    )
    print("   n   F N  Y kPa  E/Y  spin   rule  known   at 200  known   ms/rev")
    for (count, force, stress, ratio, spin), (rule, known) in LONG.items():
        lump = tumbled(0.025, count, 1)
        start = time.process_time()
        found, heights, _ = roll(
            lump, "circle", [400 * math.pi * lump.ball], Dough(stress, ratio * stress), force, spin, 1
        )
        cost = (time.process_time() - start) / 200 * 1e3
        print(
            f"{count:4d}  {force:4.1f}  {stress / 1e3:5.0f}  {ratio:3d}  {spin:4.1f}  {stopped(heights)!s:>5s}  {rule!s:>5s}"
            f"  {found[0]:7.3f}  {known:5.3f}  {cost:7.2f}"
        )


def timed(call: Callable[[], Any], times: int) -> float:
    """Return the median CPU time, ms."""
    spent = []
    for _ in range(times):
        start = time.process_time()
        call()
        spent.append(1e3 * (time.process_time() - start))
    return float(np.median(spent))


def volume() -> None:
    lump = cube(0.025, 500)
    leg = 400 * math.pi * lump.ball
    start = time.process_time()
    for k in range(100):
        lump, _ = lump.rolled((leg * math.cos(k), leg * math.sin(k)), 1.0, Dough(5e3, 1e5), weight=0.19, spin=0.05)
    drift = np.sum(lump.radii**3) * lump.directions.solid_angle / 3 / lump.volume - 1
    print(
        f"\nvolume drift after {lump.steps / 60:.0f} revolutions, n = 500: {drift:.1e} ({time.process_time() - start:.1f} s)"
    )


def spring(stiffness: float, depth: float) -> tuple[float, float]:
    return stiffness * depth, stiffness


def law() -> None:
    print("\nforce law: CPU time to make it and to ask it, and evaluations with a membrane of 1e-3 to 1e3 x 2.6 N/mm")
    for name, dough in {
        "plastic": Dough(5e3, 1e5),
        "hardly elastic": Dough(5e3, 1e7),
        "viscous": Dough(5e3, 1e5, 500.0),
        "elastic": Dough(1e9, 1e5),
    }.items():
        spent = []
        for seed in range(4):
            lump = roll(tumbled(0.025, 500, seed), "eight", [0.5 * seed + 0.01], Dough(5e3, 1e5), 1.0, 0.0, seed)[2]
            felt = Resistance(lump, dough, 0.19)
            for stiffness in 2.6e3 * 10.0 ** np.arange(-3, 3.1, 0.25):
                for travel in (1e-4, 2e-3, 7e-3):
                    membrane = partial(spring, stiffness)
                    spent.append(couple(membrane, partial(felt.force, dt=0.1), travel).iterations)
        made, asked = (
            timed(partial(Resistance, lump, dough, 0.19), 9),
            timed(partial(felt.force, 1e-3), 99),
        )
        print(
            f"{name:15s} {made:6.3f} ms {1e3 * asked:6.1f} us   median {np.median(spent):.0f}, most {max(spent)} of {len(spent)}"
        )


def sheet() -> None:
    print(
        "\nthe sheet on the lump's upper side, stretch 60 mm, depth 5 mm: CPU time, beside the sphere of the same volume"
    )
    for travel in (0.1, 0.5, 2.0, 4.0):
        lump = roll(tumbled(0.025, 500, 3), "eight", [travel], Dough(5e3, 1e5), 1.0, 0.0, 3)[2]
        made = timed(partial(upper_side, lump), 9)
        body = upper_side(lump)
        found, ball = press(body, 0.06, 5e-3), press(f"sphere:{2e3 * lump.ball:.4f}mm", 0.06, 5e-3)
        print(
            f"{travel:4.1f} m  roundness {lump.roundness:.3f}  made in {made:5.2f} ms  force {found.force:.3f} N in"
            f" {1e3 * found.seconds:4.0f} ms, {found.iterations} iterations; sphere {ball.force:.3f} N in {1e3 * ball.seconds:3.0f} ms"
        )


def main() -> None:
    forces()
    law()
    sheet()
    volume()
    long()


if __name__ == "__main__":
    main()
