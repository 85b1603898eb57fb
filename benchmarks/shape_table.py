"""The table of shapes behind the height from the whole membrane: made, and checked against presses of other hands.

    python -m benchmarks.shape_table make [--workers 2]
    python -m benchmarks.shape_table check [--hands 12]

A press of a sphere in the middle of a sheet of 100 by 90 mm, 1, 2 and 3 mm thick, that resists bending: the height of one quarter of it over
the depth, without weight, and for 2 mm what weight adds over the hang of the free sheet. It takes some ten minutes of one core. The check presses
hands that differ in thickness, modulus, energy, friction and softening, and fits the table to their shapes as perception does.
"""

from __future__ import annotations

import argparse
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt
from joblib import Parallel, delayed

from stretch_bt.accuracy.force.hands import TrueHand
from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception.pressed.height import MountedMembrane, membrane_height
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import rubber
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.hanging import hang, lowest
from stretch_bt.simulation.membrane.sheet.result import Load, Shape, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.units import Estimate

Array = npt.NDArray[np.float64]

TABLE = Path(__file__).parents[1] / "stretch_bt" / "perception" / "pressed" / "shapes.npz"
GAUGE, WIDTH, MODULUS = 0.1, 0.09, 70e3
THICKNESSES = np.array([1, 2, 3]) * 1e-3
MIDDLE = 1  # index of the thickness that is also solved with weight
DIAMETERS = np.array([10, 16, 24, 36, 54, 80, 120]) * 1e-3
SPANS = np.array([5, 8, 12, 16, 21, 28, 40, 60, 100]) * 1e-3
DEPTHS = np.array([0.75, 1.5, 3, 5, 8, 12, 18]) * 1e-3
ACROSS = np.linspace(0.0, 0.76, 20)  # of half the width at stretch 0
ALONG = np.linspace(0.0, 0.96, 26)  # of half the length
UNIT = 5e-4  # of the height over the depth, and of what weight adds over the hang
DENSE = 241
SEEN = 320  # points a side, of which perception takes every fourth
CURVATURE_SD = 0.03  # of itself
BENDING, WEIGHED = Effects(bending=True), Effects(bending=True, sag=DENSITY)


def main() -> None:
    """Make the table, or check it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("make", "check"))
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--hands", type=int, default=6)
    given = parser.parse_args()
    make(given.workers) if given.what == "make" else check(given.hands)


def make(workers: int) -> None:
    """Write the table."""
    places = [(float(d), float(x)) for d in DIAMETERS for x in SPANS]
    shape = len(DIAMETERS), len(SPANS), len(DEPTHS), len(ALONG), len(ACROSS)
    lifted, hung = np.zeros((len(THICKNESSES), *shape)), np.zeros(shape)
    deepest, free = np.zeros(shape[:2]), np.zeros(len(SPANS))
    pool = Parallel(workers, return_as="generator")
    for k, (*parts, free_hang, depth) in enumerate(pool(delayed(_shapes)(place) for place in places)):
        i, j = divmod(k, len(SPANS))
        (lifted[:, i, j], hung[i, j]), free[j], deepest[i, j] = parts, free_hang, depth
        print(f"{k + 1} of {len(places)}", flush=True)
    TABLE.parent.mkdir(exist_ok=True)
    np.savez_compressed(
        TABLE,
        lifted=np.round(lifted / UNIT).astype(np.int16),
        thicknesses=THICKNESSES,
        hung=np.round(hung / UNIT).astype(np.int16),
        unit=UNIT,
        diameters=DIAMETERS,
        spans=SPANS,
        depths=DEPTHS,
        across=ACROSS,
        along=ALONG,
        deepest=deepest,
        free=free,
        gauge=GAUGE,
        width=WIDTH,
    )


def _shapes(place: tuple[float, float]) -> tuple[Array, Array, float, float]:
    """Return lifted (thicknesses, depths, along, across) and hung (depths, along, across), the free sheet's hang and the deepest press, m.

    Past the deepest press the shapes are the deepest press's.
    """
    diameter, span = place
    sheets = [_sheet(float(t), BENDING) for t in THICKNESSES] + [_sheet(float(THICKNESSES[MIDDLE]), WEIGHED)]
    free = -float(hang(sheets[-1], span).points(3, 3)[1, 1, 2])
    lifted: list[Array] = []
    hung: list[Array] = []
    deepest = 0.0
    last: list[SheetPress | None] = [None] * len(sheets)
    for depth in DEPTHS.tolist():
        try:
            last = [_pressed(sheet, diameter, span, depth, before) for sheet, before in zip(sheets, last, strict=True)]
        except NoEquilibrium:
            lifted.append(lifted[-1])
            hung.append(hung[-1])
            continue
        *without, weighed = (_quarter(press.shape, span) for press in last if press is not None)
        lifted.append(np.array([quarter / quarter[0, 0] for quarter in without]))
        own = without[MIDDLE]
        hung.append((weighed - weighed[0, 0] - (own - own[0, 0])) / free)
        deepest = depth
    return np.moveaxis(np.array(lifted), 1, 0), np.array(hung), free, deepest


def _sheet(thickness: float, effects: Effects) -> Sheet:
    return Sheet(GAUGE, WIDTH, thickness, rubber(MODULUS, 0.0), 0.0, effects)


def _pressed(sheet: Sheet, diameter: float, span: float, depth: float, before: SheetPress | None) -> SheetPress:
    lift = lowest(sheet, span) if sheet.effects.sag else 0.0
    return solve(sheet, Load(Sphere(diameter), span, depth, (0.0, 0.0), (0.0, 0.0), lift), Settings(), before)


def check(hands: int) -> None:
    """Print the error of the fitted height for hands that the table does not know, without noise."""
    print("diameter  stretch  depth, mm   height off by, mm: mean, sd, largest   stated, mm")
    for diameter, stretch, depth in product((0.02, 0.04, 0.06), (0.0, 0.02, 0.06), (1.5e-3, 3e-3, 8e-3, 14e-3)):
        found = [_fitted(TrueHand.drawn(seed), diameter, stretch, depth) for seed in range(hands)]
        off, sd = 1e3 * np.array([(height.value - depth, height.sd) for height in found]).T
        print(
            f"{diameter * 1e3:6.0f} {stretch * 1e3:8.0f} {depth * 1e3:9.1f} {off.mean():16.3f} {off.std():7.3f} {np.abs(off).max():7.3f}"
            f" {sd.mean():18.3f}",
            flush=True,
        )


def _fitted(hand: TrueHand, diameter: float, stretch: float, depth: float) -> Estimate:
    """Return the height that perception finds for a press of a hand whose mount and hang are known."""
    sheet = hand.sheet()
    load = Load(Sphere(diameter), stretch, depth, (0.0, 0.0), (0.0, 0.0), lowest(sheet, stretch))
    points = solve(sheet, load, Settings()).shape.points(SEEN, SEEN)
    hangs = -float(hang(sheet, stretch).points(3, 3)[1, 1, 2])
    membrane = MountedMembrane(
        GAUGE, WIDTH, hand.thickness, hand.mount_prestretch + stretch, Estimate(hangs, 0.05 * hangs)
    )
    curvature = Estimate(2 / diameter, CURVATURE_SD * 2 / diameter)
    return membrane_height(points, np.ones(points.shape[:2], bool), membrane, curvature, depth)


def _quarter(shape: Shape, span: float) -> Array:
    """Return (along, across) float, m: heights of the quarter of a shape where both coordinates are at least 0.

    Beside a sheet that its stretch made narrower they are the heights of its side.
    """
    from scipy.interpolate import CloughTocher2DInterpolator, NearestNDInterpolator

    points = shape.points(DENSE, DENSE)[DENSE // 2 - 6 :, DENSE // 2 - 6 :]
    y, x = np.meshgrid(ALONG * (GAUGE + span) / 2, ACROSS * WIDTH / 2, indexing="ij")
    flat = points.reshape(-1, 3)
    z = np.asarray(CloughTocher2DInterpolator(flat[:, :2], flat[:, 2])(x, y))
    return np.where(np.isfinite(z), z, NearestNDInterpolator(flat[:, :2], flat[:, 2])(x, y))


if __name__ == "__main__":
    main()
