"""The table of forces behind the membrane force model: made, and checked against presses of the sheet between its own.

    python -m benchmarks.force_table make [--workers 2]
    python -m benchmarks.force_table check [--presses 60]

A press of a hemisphere in the middle of the sheet of 100 by 90 mm, without effects, divided by shear modulus, thickness and a
hundredth of the gauge; and what weight, bending, Mooney's second invariant, friction and softening add to it, each alone. A
softened sheet has been pressed by 10 mm and 60 mm hemispheres, 15 mm deep, at a span of 95 mm. It takes some twenty minutes of one core.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from joblib import Parallel, delayed

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.materials import rubber
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, FRICTION, Effects, Mullins
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.hanging import lowest
from stretch_bt.simulation.membrane.sheet.result import Load, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve

Array = npt.NDArray[np.float64]

TABLE = Path(__file__).parents[1] / "stretch_bt" / "model" / "data" / "membrane_force.npz"
GAUGE, WIDTH, THICKNESS, MODULUS = 0.1, 0.09, 0.002, 70e3
DIAMETERS = np.array([8, 11, 15, 20, 27, 36, 48, 64, 86, 120]) * 1e-3
SPANS = np.array([4, 8, 12, 17, 23, 30, 40, 50, 60, 75, 90, 105, 120]) * 1e-3
DEPTHS = np.array([0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 10, 12, 15, 18, 21, 25]) * 1e-3
SHARES = (0.1, 0.25)
CONDITIONED = 0.095
PASTS = np.array([-30, -20, -15, -12, -9, -6, -3, 0, 3]) * 1e-3  # m, span less the span at which the sheet was softened
CONDITIONS = ((0.010, 0.015), (0.060, 0.015))
FINE = Settings(coarsen=0.6)
TERMS: dict[str, tuple[Effects, float]] = {
    "force": (Effects(), 0.0),
    "sag": (Effects(sag=DENSITY), 0.0),
    "bending": (Effects(bending=True), 0.0),
    "mooney_low": (Effects(), SHARES[0]),
    "mooney_high": (Effects(), SHARES[1]),
    "friction": (Effects(friction=FRICTION), 0.0),
}
SOFTENED = Effects(mullins=Mullins())


def main() -> None:
    """Make the table, or check it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("make", "check"))
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--presses", type=int, default=60)
    given = parser.parse_args()
    make(given.workers) if given.what == "make" else check(given.presses)


def make(workers: int) -> None:
    """Write the table."""
    places = [(float(d), float(x)) for d in DIAMETERS for x in SPANS]
    found = np.zeros((len(TERMS), len(DIAMETERS), len(SPANS), len(DEPTHS)))
    pool = Parallel(workers, return_as="generator")
    for k, forces in enumerate(pool(delayed(_forces)(place) for place in places)):
        found[:, k // len(SPANS), k % len(SPANS)] = forces
        print(f"{k + 1} of {len(places)}", flush=True)
    softer = np.array(list(pool(delayed(_softening)(float(diameter)) for diameter in DIAMETERS)))
    print("softening", flush=True)
    base, *others = found
    reached = np.isfinite(found).all(axis=0)
    deepest = np.where(reached, DEPTHS, 0.0).max(axis=-1)
    parts = dict(zip(TERMS, map(_filled, _parts(base, others)), strict=True))
    kept: dict[str, Any] = {name: values.astype(np.float32) for name, values in parts.items()}
    np.savez_compressed(
        TABLE,
        **kept,
        diameters=DIAMETERS,
        spans=SPANS,
        depths=DEPTHS,
        shares=np.array(SHARES),
        deepest=deepest,
        gauge=GAUGE,
        width=WIDTH,
        thickness=THICKNESS,
        density=DENSITY,
        modulus=MODULUS,
        coefficient=FRICTION,
        pasts=PASTS,
        softening=softer.astype(np.float32),
    )


def _parts(base: Array, others: list[Array]) -> list[Array]:
    """Return the logarithm of the force, what weight adds to it, and by what part the other terms change it."""
    sag, *rest = others
    return [np.log(base), sag - base, *(term / base - 1 for term in rest)]


def _forces(place: tuple[float, float]) -> Array:
    """Return (terms, depths) float, the force over shear modulus, thickness and unit; not a number where there is none."""
    return np.array([_curve(*place, DEPTHS, *term) for term in TERMS.values()])


def _softening(diameter: float) -> Array:
    """Return (pasts, depths) float, the relative change of the force by earlier presses; past the deepest press its value there."""
    spans = [float(x) for x in CONDITIONED + PASTS]
    rows = [_curve(diameter, x, DEPTHS, SOFTENED, 0.0) / _curve(diameter, x, DEPTHS, Effects(), 0.0) - 1 for x in spans]
    return np.array([np.where(np.isnan(row), row[np.isfinite(row)][-1], row) for row in rows])


def _curve(diameter: float, span: float, depths: Array, effects: Effects, share: float) -> Array:
    sheet = Sheet(GAUGE, WIDTH, THICKNESS, rubber(MODULUS, share), 0.0, effects)
    lift = lowest(sheet, span) if effects.sag else 0.0
    press = partial(_press, sheet, Sphere(diameter), span, lift)
    found, last = np.full(len(depths), np.nan), _conditioned(sheet) if effects.mullins else None
    # friction remembers the way down; without it the first press is quickest where it is deep
    for k in range(len(depths)) if effects.friction or effects.mullins else range(len(depths))[::-1]:
        last = press(float(depths[k]), last)
        found[k] = last.force[2] / sheet.force_unit if last is not None else np.nan
    return found


def _conditioned(sheet: Sheet) -> SheetPress | None:
    """Return what the sheet remembers of the presses that softened it."""
    last: SheetPress | None = None
    for diameter, depth in CONDITIONS:
        last = _press(sheet, Sphere(diameter), CONDITIONED, 0.0, depth, last)
        last = last.let_go() if last is not None else None
    return last


def _press(
    sheet: Sheet, ball: Sphere, span: float, lift: float, depth: float, last: SheetPress | None
) -> SheetPress | None:
    try:
        return solve(sheet, Load(ball, span, depth, (0.0, 0.0), (0.0, 0.0), lift), FINE, last)
    except NoEquilibrium:
        return None


def _filled(values: Array) -> Array:
    """Return values (diameters, spans, depths) that go on in a straight line over the logarithm of depth where there are none."""
    out, at = values.copy(), np.log(DEPTHS)
    for i, j in np.ndindex(values.shape[:2]):
        known = np.isfinite(values[i, j])
        if not known.all():
            last = np.flatnonzero(known)[-2:]
            slope = np.diff(values[i, j, last])[0] / np.diff(at[last])[0]
            out[i, j, ~known] = values[i, j, last[1]] + slope * (at[~known] - at[last[1]])
    return out


def check(presses: int) -> None:
    """Print how far the table is off presses of the sheet between its own, without and with weight and bending."""
    from stretch_bt.model.force.force_model import Range
    from stretch_bt.model.force.membrane import MembraneHand, MembraneModel

    random = np.random.default_rng(5)
    nothing = tuple((0.0,) * len(MembraneHand._fields) for _ in MembraneHand._fields)
    limits = Range((0.004, 0.06), (0.0, 0.08), (0.0, 0.025))
    off = []
    for _ in range(presses):
        diameter, mount, stretch, depth = random.uniform([0.01, 0.008, 0.0, 0.001], [0.09, 0.016, 0.08, 0.015])
        hand = MembraneHand(float(random.uniform(50e3, 90e3)), float(random.uniform(0.0016, 0.0024)), float(mount))
        model = MembraneModel(hand, nothing, 0.0, limits)
        sheet = Sheet(
            GAUGE,
            WIDTH,
            hand.thickness,
            rubber(hand.shear_modulus),
            hand.mount_prestretch,
            Effects(sag=DENSITY, bending=True),
        )
        lift = lowest(sheet, float(stretch))
        pressed = _press(sheet, Sphere(float(diameter)), float(stretch), lift, float(depth), None)
        if pressed is not None:
            told, _ = model.predict(float(diameter) / 2, float(stretch), float(depth))
            off.append(100 * (told / float(pressed.force[2]) - 1))
            print(
                f"{1e3 * diameter:5.1f} mm, stretch {1e3 * stretch:4.1f} mm, depth {1e3 * depth:4.1f} mm: {off[-1]:+.2f} %",
                flush=True,
            )
    values = np.abs(off)
    print(
        f"{len(values)} presses: median {np.median(values):.2f} %, 90 % within {np.quantile(values, 0.9):.2f} %, largest {values.max():.2f} %"
    )


if __name__ == "__main__":
    main()
