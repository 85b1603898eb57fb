"""Error beside stated error of the sheet's forces, by kind of press: the law of stated errors is fitted to these, and must hold for them.

    python -m benchmarks.membrane_errors [--count 40] [--seed 0] [KIND ...]

Each press is solved again, from flat, on elements 0.4 times as long that grow by 1.35, or 0.2 times under steep cones, whose
tips the default mesh does not resolve. Asked: error over stated error 0.7 to 1.3 rms in each kind, and never over 4.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cube import Cube
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.press import GAUGE, WIDTH, press
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings


class Case(NamedTuple):
    """A press of the default membrane: lengths in m, angles in rad."""

    indenter: Indenter
    stretch: float
    depth: float
    at: tuple[float, float]
    tilt: tuple[float, float]


Draw = Callable[[np.random.Generator], Case]


class Kind(NamedTuple):
    """A kind of press: how its cases are drawn and solved, and the elements of the reference."""

    draw: Draw
    settings: Settings = Settings()
    finer: float = 0.4


class Compared(NamedTuple):
    """Error and stated error, over the force: along z, and of both parts across."""

    along: float
    stated: float
    across: tuple[float, float]
    stated_across: float


def _shape(rng: np.random.Generator, *more: Indenter) -> Indenter:
    size = float(rng.uniform(0.010, 0.030))
    shapes: list[Indenter] = [Sphere(size), Sphere(size), Cylinder(size), Cube(size), *more]
    return shapes[rng.integers(len(shapes))]


def _tilt(rng: np.random.Generator, most: float, share: float) -> tuple[float, float]:
    turn, lean = rng.uniform(0, 2 * math.pi), math.radians(rng.uniform(0, most))
    return (lean * math.cos(turn), lean * math.sin(turn)) if rng.random() < share else (0.0, 0.0)


def _near(rng: np.random.Generator, share: float) -> tuple[float, float]:
    x, y = rng.uniform(-0.012, 0.012, 2).tolist()
    return (x, y) if rng.random() < share else (0.0, 0.0)


def ordinary(rng: np.random.Generator) -> Case:
    """Return a press of a taut sheet near its middle."""
    shape, stretch = _shape(rng), float(rng.uniform(0.01, 0.08))
    return Case(shape, stretch, float(rng.uniform(0.001, 0.015)), _near(rng, 0.6), _tilt(rng, 15, 0.6))


def off_centre(rng: np.random.Generator) -> Case:
    """Return a press of a taut sheet anywhere, over its edges too."""
    shape, stretch = _shape(rng, Cone(math.pi / 4)), float(rng.uniform(0.01, 0.08))
    length = 1 + stretch / GAUGE
    across, along = rng.uniform(-0.5, 0.5, 2).tolist()
    at = (across * WIDTH / math.sqrt(length), along * GAUGE * length)
    return Case(shape, stretch, float(rng.uniform(0.002, 0.015)), at, _tilt(rng, 15, 0.6))


def slack(rng: np.random.Generator) -> Case:
    """Return a press of a sheet at hardly any stretch, mostly off its middle."""
    shape, stretch = _shape(rng, Cone(math.pi / 4)), float(rng.choice([0.0, 0.001, 0.003, 0.006]))
    at = (float(rng.uniform(-0.035, 0.035)), float(rng.uniform(-0.04, 0.04)))
    return Case(shape, stretch, float(rng.uniform(0.002, 0.015)), at, _tilt(rng, 15, 0.6))


def _cone(rng: np.random.Generator, least: float, most: float) -> Case:
    shape = Cone(math.radians(rng.uniform(least, most)), float(rng.choice([0.5e-3, 0.5e-3, 1e-3])))
    stretch = float(rng.choice([0.01, 0.03, 0.06, 0.08]))
    return Case(shape, stretch, float(rng.uniform(0.002, 0.012)), _near(rng, 0.4), _tilt(rng, 8, 0.3))


def cones(rng: np.random.Generator) -> Case:
    """Return a press by a cone of 25 to 55 degrees."""
    return _cone(rng, 25, 55)


def steep_cones(rng: np.random.Generator) -> Case:
    """Return a press by a cone of 55 to 73 degrees."""
    return _cone(rng, 55, 73)


def spheres(rng: np.random.Generator) -> Case:
    """Return a press by a sphere, as `Settings.within` is measured on."""
    shape, stretch = Sphere(float(rng.uniform(0.008, 0.030))), float(rng.uniform(0.01, 0.08))
    return Case(shape, stretch, float(rng.uniform(0.003, 0.015)), _near(rng, 0.5), (0.0, 0.0))


KINDS = {
    "ordinary": Kind(ordinary),
    "off-centre": Kind(off_centre),
    "slack": Kind(slack),
    "cones": Kind(cones),
    "steep-cones": Kind(steep_cones, finer=0.2),
    "coarse": Kind(ordinary, Settings(coarsen=2.0)),
    "fine": Kind(ordinary, Settings(coarsen=0.6), 0.25),
    "within-3": Kind(spheres, Settings.within(0.03)),
    "within-1": Kind(spheres, Settings.within(0.01)),
    "within-0.3": Kind(spheres, Settings.within(0.003)),
}


def compare(case: Case, kind: Kind) -> Compared | None:
    """Return the error of a press, None where it or its reference has no equilibrium."""
    fine = Settings(coarsen=kind.finer, growth=1.35, budget=3000)
    try:
        found, finer = (press(**case._asdict(), settings=settings).detail for settings in (kind.settings, fine))
    except NoEquilibrium:
        return None
    assert isinstance(found, SheetPress)
    assert isinstance(finer, SheetPress)
    force = float(finer.force[2])
    x, y, z = ((found.force - finer.force) / force).tolist()
    return Compared(z, found.force_error / force, (x, y), found.side_error / force)


def ratios(compared: list[Compared]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return errors over stated errors, along z (n,) and across (2 n,)."""
    along = np.array([c.along / c.stated for c in compared])
    return along, np.array([part / c.stated_across for c in compared for part in c.across])


def report(name: str, count: int, seed: int) -> None:
    """Print the line of a kind."""
    rng = np.random.default_rng(seed)
    kind = KINDS[name]
    found = [compare(kind.draw(rng), kind) for _ in range(count)]
    compared = [c for c in found if c is not None]
    along, across = ratios(compared)
    error, stated = (100 * float(np.median(np.abs([getattr(c, f) for c in compared]))) for f in ("along", "stated"))
    print(
        f"{name:12} {len(compared):3d} of {count}: force off by {error:.2f} % (median), at most "
        f"{100 * max(abs(c.along) for c in compared):.1f} %, stated {stated:.2f} %; over stated: rms "
        f"{math.sqrt(np.mean(along**2)):.2f}, most {np.abs(along).max():.1f}; sides: rms "
        f"{math.sqrt(np.mean(across**2)):.2f}, most {np.abs(across).max():.1f}",
        flush=True,
    )


def main() -> None:
    """Print the kinds that are named, or all."""
    parser = argparse.ArgumentParser()
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    press("sphere:20mm", 0.03, 0.01)  # compiles
    for name in given.kinds:
        report(name, given.count, given.seed)


if __name__ == "__main__":
    main()
