"""How far a membrane that resists bending stands above a flat top, against the law of a face that is known.

    python -m benchmarks.lift_off [--bodies 200] [--seed 0] [--fit]

Discs and blocks of 12 to 40 mm with edges of 0.5 to 10 mm are drawn, pressed 3 to 14 mm deep into the solved sheet, 1 to 2 mm thick, its gauge
50 to 120 mm, at strains of 0.06 to 0.8; none is wider than half the gauge, or pressed deeper than a fifth of it. The lift is how far the sheet
stands above the middle of the face; the printed errors are the law's, for the whole lift. `--fit` prints the law fitted to
the draws by least squares of the logarithms.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception.robust import MAD_TO_SD
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.threads import one_thread

SHEAR = 68.4e3  # Pa
# The lift over the thickness, by powers of depth, half the size and thickness over the gauge, of the strain, and of the face's length along j over
# its width along i, as the sides along the stretch are those that lift it; the factor, and the standard deviation as a part of the lift: by
# `--fit` of 300 bodies. `perception/drum.py` has the law of what a camera sees.
FACTOR, DEPTH, SIZE, THICKNESS, STRAIN, ASPECT = 0.315, 0.781, -0.370, 0.103, -0.385, 0.762
PART = 0.3
ROUNDS = 10
LEAST_LIFT = 2e-5  # m, below which the sheet's mesh resolves no lift
SHAPES = {"wide": 1 / 1.2, "even": 1.2, "long": math.inf}  # by length along j over width along i, at most
SHARP = 0.35  # of half the shorter side
STRETCHES = (0.0, 0.0, 0.1, 0.2, 0.4, 0.6)  # of the gauge


@dataclass(frozen=True)
class Drawn:
    """A press: half the size of the face, its depth, the membrane's thickness and gauge, m, its strain; `lift`, m, is what came of it.

    `aspect` is the face's length along j over its width along i, `edge` the radius of its edges over half its shorter side.
    """

    half: float
    depth: float
    thickness: float
    gauge: float
    strain: float
    aspect: float
    edge: float
    lift: float

    @property
    def family(self) -> str:
        """What it belongs to, by the shape of its face and by its edges."""
        shape = next(name for name, most in SHAPES.items() if self.aspect <= most)
        return f"{shape}, {'sharp' if self.edge < SHARP else 'wide'} edges"


def drawn(rng: np.random.Generator) -> Drawn:
    """Draw a press and solve it; raises NoEquilibrium."""
    gauge = float(rng.uniform(50e-3, 120e-3))
    width, thickness = gauge * float(rng.uniform(0.7, 1.1)), float(rng.uniform(1e-3, 2e-3))
    body = _body(rng, min(40e-3, 0.5 * gauge))
    mount, stretch = gauge * float(rng.uniform(0.06, 0.2)), gauge * float(rng.choice(STRETCHES))
    depth = float(rng.uniform(3e-3, min(14e-3, 0.2 * gauge)))
    sheet = Sheet(gauge, width, thickness, NeoHookean(SHEAR), mount, Effects(sag=DENSITY, bending=True))
    lift = lift_over(body, depth, sheet, stretch)
    first, second = (body.diameter, body.diameter) if isinstance(body, Cylinder) else (body.first, body.second)
    half, edge = 0.5 * math.sqrt(first * second), 2.0 * body.feature / min(first, second)
    return Drawn(half, depth, thickness, gauge, (mount + stretch) / gauge, second / first, edge, lift)


def _body(rng: np.random.Generator, most: float) -> Cylinder | Box:
    """Draw a disc or a block as wide as `most`, m, or less."""
    first, second = rng.uniform(12e-3, most, 2).tolist()
    disc = rng.random() < 0.6
    edge = min(
        float(np.exp(rng.uniform(math.log(0.5e-3), math.log(10e-3)))), 0.4 * (first if disc else min(first, second))
    )
    return Cylinder(first, edge) if disc else Box(first, second, edge=edge)


def lift_over(body: Cylinder | Box, depth: float, sheet: Sheet, stretch: float) -> float:
    """Return how far the solved sheet stands above the middle of the face of a body that is pressed so deep, m; raises NoEquilibrium."""
    press = solve(sheet, Load(body, stretch, depth, (0.0, 0.0), (0.0, 0.0)), Settings(exact=False, corrected=False))
    return float(press.shape.points(3, 3)[1, 1, 2]) - depth


def by_law(press: Drawn) -> float:
    """Return the lift of a flat top by the law, m."""
    return lift_of_flat(press.depth, press.half, press.thickness, press.strain, press.gauge, press.aspect)


def lift_of_flat(
    height: float, radius: float, thickness: float, strain: float, gauge: float, aspect: float = 1.0
) -> float:
    """Return how far a membrane of a gauge stands above the middle of a flat face of half a size, m, that is so many times as long along j."""
    depth, size, thin = height / gauge, radius / gauge, thickness / gauge
    return float(thickness * FACTOR * depth**DEPTH * size**SIZE * thin**THICKNESS * strain**STRAIN * aspect**ASPECT)


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
    over = off / (PART * law)
    print(f"error over stated: rms {np.sqrt(np.mean(over**2)):.2f}, most {np.abs(over).max():.1f}")
    for family in sorted({p.family for p in presses}):
        those = over[[p.family == family for p in presses]]
        print(
            f"  {family:18s} {len(those):3d}: rms {np.sqrt(np.mean(those**2)):.2f}, mean {those.mean():+.2f}, most {np.abs(those).max():.1f}"
        )
    if given.fit:
        _fit(presses)


def _fit(presses: list[Drawn]) -> None:
    """Print the law of the logarithms; its factor is the one that leaves no error in the mean, and its part the rms of what is left."""
    columns = np.array(
        [
            [1.0, *np.log([p.depth / p.gauge, p.half / p.gauge, p.thickness / p.gauge, p.strain, p.aspect])]
            for p in presses
        ]
    )
    lift = np.array([max(p.lift, LEAST_LIFT) / p.thickness for p in presses])
    fitted, weights = np.zeros(columns.shape[1]), np.ones(len(presses))
    for _ in range(ROUNDS):  # Huber's weights: a lift that is nearly none has a logarithm of no use
        fitted = np.linalg.lstsq(columns * weights[:, None], np.log(lift) * weights, rcond=None)[0]
        left = np.abs(np.log(lift) - columns @ fitted)
        weights = np.sqrt(1.0 / np.maximum(1.0, left / (1.5 * MAD_TO_SD * np.median(left))))
    over = lift / np.exp(columns @ fitted)
    print(f"factor {math.exp(fitted[0]) * over.mean():.3f}; part {over.std() / over.mean():.2f}")
    print(
        f"powers of depth, half the size and thickness over the gauge, of the strain and of the aspect {fitted[1:].round(3)}"
    )


def _spread(values: np.ndarray) -> str:
    return ", ".join(f"{1e3 * v:.2f}" for v in np.percentile(values, [0, 10, 50, 90, 100]))


if __name__ == "__main__":
    main()
