"""How far a membrane that resists bending stands above a top that bows a little, against what `perception.lift_off` states.

    python -m benchmarks.bowed_tops [--bodies 120] [--seed 0]

Discs of 12 to 32 mm with edges of 0.7 to 6 mm, half of them flat, the others with tops whose radius is 1.5 to 60 times the disc's, are pressed
3 to 12 mm deep into the solved sheet of a gauge of 80 to 110 mm, 1.2 to 2 mm thick, stretched by 0 to 60 mm. The lift is how far the sheet stands
above the middle of the top. All of the sheet within the outermost place of contact counts as contact; there is no noise.
"""

from __future__ import annotations

import argparse
import math
import warnings
from dataclasses import dataclass

import numpy as np

from stretch_bt.errors import NoEquilibrium
from stretch_bt.perception import lift_off
from stretch_bt.perception.types import CONTACT, UNDEFORMED
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS
from stretch_bt.threads import one_thread
from stretch_bt.units import Estimate

STRETCHES = (0.0, 0.0, 10e-3, 20e-3, 40e-3, 60e-3)  # m
PITCH, AROUND, STEEP = 0.25e-3, 3e-3, 8.0  # m between heights and beside the disc; slope of its side
ROWS, COLUMNS = 221, 181
MESH = 0.01e-3  # m, standard deviation of the lift's error from the sheet's mesh


@dataclass(frozen=True)
class Bowed:
    """A press: whether its top is flat, how far the sheet stands above it, m, and the estimate of that."""

    flat: bool
    lift: float
    told: Estimate

    @property
    def over(self) -> float:
        """Error over stated deviation."""
        return (self.told.value - self.lift) / math.hypot(self.told.sd, MESH)


def drawn(rng: np.random.Generator) -> Bowed:
    """Draw a press, solve it and look at it; raises NoEquilibrium."""
    half = float(rng.uniform(6e-3, 16e-3))
    edge = min(float(np.exp(rng.uniform(math.log(0.7e-3), math.log(6e-3)))), 0.5 * half)
    flat, radius = rng.random() < 0.5, half * float(np.exp(rng.uniform(math.log(1.5), math.log(60.0))))
    depth, stretch = float(rng.uniform(3e-3, 12e-3)), float(rng.choice(STRETCHES))
    gauge, thickness = float(rng.uniform(80e-3, 110e-3)), float(rng.uniform(1.2e-3, 2e-3))
    sheet = Sheet(
        gauge, 0.9 * gauge, thickness, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, Effects(sag=DENSITY, bending=True)
    )
    body = HeightField(heights(half, edge, math.inf if flat else radius), PITCH)
    press = solve(sheet, Load(body, stretch, depth, (0.0, 0.0), (0.0, 0.0)), Settings.within(0.01))
    points = press.points_outside(COLUMNS, ROWS)
    away = np.hypot(points[..., 0], points[..., 1])
    outermost = float(np.hypot(*press.region().points[:, :2].T).max())
    labels = np.where(away <= outermost, CONTACT, UNDEFORMED).astype(np.uint8)
    strain = Estimate((MOUNT_PRESTRETCH + stretch) / gauge, 0.0)
    told = lift_off(points, labels, float(points[..., 2].max()), thickness, strain, gauge)
    return Bowed(flat, float(press.points_outside(3, 3)[1, 1, 2]) - depth, told)


def heights(half: float, edge: float, radius: float) -> np.ndarray:
    """Return the heights (n, n), m, of a disc of half a width, with an edge of a radius and a top of another; 0 at its top."""
    count = math.ceil((half + AROUND) / PITCH)
    places = np.arange(-count, count + 1) * PITCH
    away = np.hypot(*np.meshgrid(places, places))
    fillet = edge * (1.0 - np.sqrt(1.0 - np.clip((away - half + edge) / edge, 0.0, 1.0) ** 2))
    top = -(np.minimum(away, half) ** 2) / (2.0 * radius) - fillet
    return np.asarray(np.where(away > half, top - edge - STEEP * (away - half), top))


def main() -> None:
    """Print error over stated for flat tops and for tops that bow."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=120)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng, presses, refused = np.random.default_rng(given.seed), list[Bowed](), 0
    with one_thread(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(given.bodies):
            try:
                presses.append(drawn(rng))
            except NoEquilibrium:
                refused += 1
    print(f"{refused} of {given.bodies} without an equilibrium")
    for name, flat in (("flat", True), ("bowed", False)):
        those = [p for p in presses if p.flat == flat]
        over, off = np.array([p.over for p in those]), np.array([p.told.value - p.lift for p in those])
        stated = np.mean([p.told.sd for p in those])
        print(
            f"{name:5s} {len(those):3d}: error, mm, rms {1e3 * np.sqrt(np.mean(off**2)):.3f}; stated, mean {1e3 * stated:.3f};"
            f" error over stated rms {np.sqrt(np.mean(over**2)):.2f}, mean {over.mean():+.2f}, most {np.abs(over).max():.1f}"
        )


if __name__ == "__main__":
    main()
