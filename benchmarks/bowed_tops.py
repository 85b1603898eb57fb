"""How far a membrane that resists bending stands above a top, flat or not, against what `perception.lift_off` states of what a camera sees.

    python benchmarks/bowed_tops.py [--bodies 130] [--seed 0] [--noise NAME ...]

Discs and blocks of 12 to 36 mm with edges of 0.7 to 8 mm, discs whose tops have 1.5 to 60 times their radius, balls, and lying cylinders are
pressed 3 to 12 mm deep into the solved sheet of a gauge of 85 to 110 mm, 1.2 to 2 mm thick, stretched by 0 to 60 mm. The lift is how far
the top that `track_height` reads with hardly any noise stands above the body's; contact is what `find_contact` finds in frames with the noises
of `benchmarks.height_noise`.
"""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from height_noise import LONG, NOISES, PITCH, WIDE, Surface, seen, viewed

from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception import Contact, find_contact, lift_off, track_height
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.several import Several
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import turn
from stretch_bt.simulation.membrane.materials.neo_hookean import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.result import Load, SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.membrane.sheet.solver import solve
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS
from stretch_bt.threads import one_thread
from stretch_bt.units import Estimate

KINDS = {"disc": 0.3, "block": 0.25, "bowed": 0.2, "ball": 0.15, "lying": 0.1}
CASES = ("white 0.05", "SR305", "white 0.3", "bench, 8 frames", "bench")
QUIET = "white 0.05"
STRETCHES = (0.0, 0.0, 10e-3, 20e-3, 40e-3, 60e-3)  # m
FINE, AROUND, STEEP = 0.25e-3, 3e-3, 8.0  # m between heights of a disc and beside it; slope of its side
ROWS, COLUMNS = 241, 181


@dataclass(frozen=True)
class Lifted:
    """A frame of a press: the kind of body, the noise, how far the quiet top stands above the body's, m, and the estimates of that and of the top.

    `depth`, m, is the height of the body's top.
    """

    kind: str
    noise: str
    lift: float
    told: Estimate
    top: Estimate
    depth: float

    @property
    def over(self) -> float:
        """Error over stated deviation."""
        return (self.told.value - self.lift) / self.told.sd

    @property
    def over_height(self) -> float:
        """The same of the height of the body's top."""
        return (self.top.value - self.told.value - self.depth) / math.hypot(self.top.sd, self.told.sd)


def drawn(seed: int, noises: tuple[str, ...] = CASES) -> Iterator[Lifted]:
    """Draw a press, solve it and look at it in each noise; raises NoEquilibrium."""
    rng = np.random.default_rng([78, seed])
    kind = str(rng.choice(list(KINDS), p=list(KINDS.values())))
    body = _body(kind, rng)
    depth, stretch = float(rng.uniform(3e-3, 12e-3)), float(rng.choice(STRETCHES))
    gauge, thickness = float(rng.uniform(85e-3, 110e-3)), float(rng.uniform(1.2e-3, 2e-3))
    effects = Effects(sag=DENSITY, bending=True)
    sheet = Sheet(gauge, 0.9 * gauge, thickness, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, effects)
    press = solve(sheet, Load(body, stretch, depth, (0.0, 0.0), (0.0, 0.0)), Settings.within(0.01))
    surface = _seen_from_above(press, depth)
    lift = max(_found(surface, QUIET, seed)[1].value - depth, 0.0)  # one that is read too low is not lifted
    strain = Estimate((MOUNT_PRESTRETCH + stretch) / gauge, 0.0)
    for noise in noises:
        try:
            contact, top = _found(surface, noise, seed)
            told = lift_off(contact.surface, contact.labels, top.value, thickness, strain, gauge)
        except NoAnswer:
            continue
        yield Lifted(kind, noise, lift, told, top, depth)


def _found(surface: Surface, noise: str, seed: int) -> tuple[Contact, Estimate]:
    """Return the contact and the height of the top, m, that a frame shows."""
    contact = find_contact(seen(surface, NOISES[noise], np.random.default_rng(seed)))
    return contact, track_height(contact.surface, np.isfinite(contact.surface[..., 2]), contact.labels)


def _body(kind: str, rng: np.random.Generator) -> Indenter | Several:
    """Draw a body of a kind; every kind takes as many numbers from the generator."""
    half = float(rng.uniform(6e-3, 18e-3))
    edge = min(float(np.exp(rng.uniform(math.log(0.7e-3), math.log(8e-3)))), 0.6 * half)
    other, turned = float(rng.uniform(6e-3, 18e-3)), float(rng.choice([0.0, 0.0, math.pi / 2]))
    radius = half * float(np.exp(rng.uniform(math.log(1.5), math.log(60.0))))
    if kind == "ball":
        return Sphere(2 * half)
    if kind == "block":
        return Box(2 * half, 2 * other, edge=min(edge, 0.6 * min(half, other)))
    if kind == "lying":
        return turn(HalfCylinder(2 * half, 2 * other), turned)
    return HeightField(heights(half, edge, math.inf if kind == "disc" else radius), FINE)


def heights(half: float, edge: float, radius: float) -> np.ndarray:
    """Return the heights (n, n), m, of a disc of half a width, with an edge of a radius and a top of another; 0 at its top."""
    count = math.ceil((half + AROUND) / FINE)
    places = np.arange(-count, count + 1) * FINE
    away = np.hypot(*np.meshgrid(places, places))
    fillet = edge * (1.0 - np.sqrt(1.0 - np.clip((away - half + edge) / edge, 0.0, 1.0) ** 2))
    top = -(np.minimum(away, half) ** 2) / (2.0 * radius) - fillet
    return np.asarray(np.where(away > half, top - edge - STEEP * (away - half), top))


def _seen_from_above(press: SheetPress, depth: float) -> Surface:
    from scipy.interpolate import LinearNDInterpolator

    points = press.points_outside(COLUMNS, ROWS).reshape(-1, 3)
    x, y = np.arange(-WIDE, WIDE + PITCH / 2, PITCH), np.arange(-LONG, LONG + PITCH / 2, PITCH)
    z = LinearNDInterpolator(points[:, :2], points[:, 2], fill_value=0.0)(*np.meshgrid(x, y))
    return Surface(viewed(x, y, z), depth)


def main() -> None:
    """Print errors of the lift, and over what is stated, by noise and kind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=130)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", nargs="*", default=list(CASES))
    given = parser.parse_args()
    found, refused = list[Lifted](), 0
    with one_thread(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in range(given.seed, given.seed + given.bodies):
            try:
                found += drawn(seed, tuple(given.noise))
            except NoEquilibrium:
                refused += 1
    print(f"{refused} of {given.bodies} without an equilibrium")
    print("noise            body    n   lift, mm: rms error  stated  over stated, most   height over stated")
    for noise in given.noise:
        for kind in KINDS:
            if those := [f for f in found if f.noise == noise and f.kind == kind]:
                print(f"{noise:16s} {kind:6s} {_line(those)}")


def _line(those: list[Lifted]) -> str:
    off, over = np.array([f.told.value - f.lift for f in those]), np.array([f.over for f in those])
    height, stated = np.array([f.over_height for f in those]), np.median([f.told.sd for f in those])
    return (
        f"{len(those):3d} {1e3 * np.sqrt(np.mean(off**2)):20.3f} {1e3 * stated:7.3f} {np.sqrt(np.mean(over**2)):12.2f}"
        f" {np.abs(over).max():5.1f} {np.sqrt(np.mean(height**2)):20.2f}"
    )


if __name__ == "__main__":
    main()
