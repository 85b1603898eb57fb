"""The force with which dough resists: below its yield, at any rate, and against a membrane of any stiffness."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from stretch_bt.hardcases.expect import Check, Range, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.coupling import Equilibrium, couple
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance

EDGE = 0.025
DOUGHS = {
    "dough": Dough(5e3, 1e5),
    "stiff dough": Dough(5e3, 1e7),
    "viscous dough": Dough(5e3, 1e5, 500.0),
    "hard dough": Dough(1e9, 1e5),
}


def _rising(dough: Dough, step: float) -> list[float]:
    """Return the forces of a lump that was rolled, up to past its height."""
    lump, _ = cube(EDGE).rolled((0.15, 0.0), 1.0, Dough(5e3, 1e5))
    felt = Resistance(lump, dough, 0.19)
    return [felt.force(drop, step)[0] for drop in np.linspace(0, 1.2 * lump.height, 200).tolist()]


def _rises(forces: list[float]) -> bool:
    rises = (np.diff(forces) >= -1e-9 * forces[-1]).all()
    return bool(np.isfinite(forces).all() and rises and forces[0] <= 1e-6)


def _met(dough: Dough, exponent: float) -> list[tuple[Equilibrium, float]]:
    """Return where dough meets a membrane of a stiffness after three travels, and the force of the dough there, N."""
    stiffness, felt = 10**exponent * 2.6e3, Resistance(cube(EDGE), dough, 0.19)
    found = [couple(lambda d: (stiffness * d, stiffness), lambda d: felt.force(d, 0.1), t) for t in (1e-4, 2e-3, 7e-3)]
    return [(each, felt.force(each.drop, 0.1)[0]) for each in found]


def _in_few(found: list[tuple[Equilibrium, float]]) -> bool:
    totals = zip(found, (1e-4, 2e-3, 7e-3), strict=True)
    return all(
        each.iterations <= 10 and abs(each.force / force - 1) < 1e-6 and abs((each.depth + each.drop) / t - 1) < 1e-9
        for (each, force), t in totals
    )


def _set_left(step: float) -> tuple[float, float]:
    """Return the drop that a viscous press leaves over a slow one's, and its step in time constants of the hand's spring."""
    spring, travel, lump = 300.0, 8e-3, cube(EDGE)
    slow, viscous = (Dough(2e3, 1e6, thickening, power=1.0) for thickening in (0.0, 1e3))
    felt, lasting = Resistance(lump, slow), Resistance(lump, viscous)
    end = couple(lambda d: (spring * d, spring), felt.force, travel)
    # roughly: thickening x section / height over the spring's stiffness
    dt = step * viscous.thickening * EDGE / spring
    found = couple(lambda d: (spring * d, spring), lambda d: lasting.force(d, dt), travel)
    return lasting.plastic(found.drop, dt) / felt.plastic(end.drop), step


def _not_past_it(found: tuple[float, float]) -> bool:
    part, step = found
    return 0 <= part <= 1 + 1e-9 and (step < 1e3 or part > 0.95)


def _below_yield() -> list[float]:
    """Return the drop that stays, m, force over a punch's, less 1, and slope over force by drop, less 1."""
    felt = Resistance(cube(EDGE), Dough(1e9, 1e5))
    force, slope = felt.force(1e-3)
    punch = 2 * (1e5 / 0.75) * math.sqrt(EDGE**2 / math.pi) * 1e-3
    return [felt.plastic(1e-3), force / punch - 1, slope * 1e-3 / force - 1]


CASES: tuple[Hard, ...] = (
    *group(
        "yields from 1 Pa to 1 GPa, any springback, thickening and rate: force must not fall with the drop",
        {
            f"yield 1e{exponent:g} Pa, modulus {ratio:g} times, thickening {thickening:g}, 1e{step:g} s": (
                partial(_rising, Dough(10.0**exponent, ratio * 10.0**exponent, thickening), 10.0**step),
                Check("rises from nothing", _rises),
            )
            for exponent, ratio, thickening, step in (
                (0, 1.0, 0.0, 0),
                (0, 1e3, 1e6, -3),
                (4, 20.0, 0.0, 3),
                (4, 20.0, 1.0, -3),
                (9, 1.0, 1e6, 3),
                (9, 1e3, 0.0, 0),
            )
        },
    ),
    *group(
        "an explicit update overshoots where a step is longer than two time constants of the hand's spring",
        {
            f"a step of {step:g} times of the spring": (
                partial(_set_left, step),
                Check("leaves at most what a slow press does, and that after a long one", _not_past_it),
            )
            for step in (0.1, 1.9, 2.1, 10.0, 1e3)
        },
    ),
    *group(
        "dough of a thousandth to a thousand times the membrane's stiffness",
        {
            f"{name} under a membrane of 1e{exponent:+g}": (
                partial(_met, dough, exponent),
                Check("forces within 1e-6 in 10 evaluations", _in_few),
            )
            for name, dough in DOUGHS.items()
            for exponent in np.linspace(-3, 3, 13).tolist()
        },
    ),
    *group(
        "flow and springback each stand alone at an end",
        {
            "a cube on its face flows at its section": (
                lambda: Resistance(cube(EDGE), Dough(5e3, 1e5)).force(5e-3)[0] / (1.2 * 5e3 * EDGE**3 / (EDGE - 5e-3)),
                Value(1.0, abs=0.05),
            ),
            "below its yield a press comes back": (_below_yield, Value([0.0, 0.0, 0.0], abs=0.1)),
            "below its yield nothing stays": (
                lambda: Resistance(cube(EDGE), Dough(1e9, 1e5)).plastic(1e-3),
                Range(0.0, 1e-15),
            ),
        },
    ),
)
