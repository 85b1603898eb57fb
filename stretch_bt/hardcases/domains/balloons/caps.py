"""Inflated caps under a hand: no cap, too deep, no pressure to speak of, any fill, and past the ends of their table."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.balloons.balance import CapBalance
from stretch_bt.simulation.balloons.cap import HAND, PLATE, Cap
from stretch_bt.simulation.balloons.curve import PowerCurve
from stretch_bt.simulation.balloons.elements import volume
from stretch_bt.simulation.balloons.filling import Filling, Gas, Liquid
from stretch_bt.simulation.balloons.fills import cap_volume
from stretch_bt.simulation.balloons.table import read_table

RADIUS, PRESSURE = 0.030, 3983.0
AIR = 101_325.0
BELOW = cap_volume(RADIUS)
FILLS: dict[str, Filling] = {
    "constant pressure": Gas(1.0),
    "isothermal": Gas(BELOW),
    "adiabatic": Gas(BELOW, 1.4),
    "liquid": Liquid(),
}
#: forces, N, under a plate after 2, 4 and 6 mm, to two digits, of a solver with 24 rings and derivatives by differences
KNOWN = {
    "constant pressure": (0.03, 0.10, 0.20),
    "isothermal": (0.39, 1.10, 2.22),
    "adiabatic": (0.39, 1.12, 2.27),
    "liquid": (0.41, 1.17, 2.40),
}
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "radius 0": ({"radius": 0.0}, "radius"),
    "pressure below 0": ({"pressure": -1.0}, "pressure"),
    "pressure NaN": ({"pressure": math.nan}, "pressure"),
    "an infinitely stiff hand": ({"hand": math.inf}, "hand"),
    "a slack skin": ({"prestretch": 1.0}, "prestretch"),
    "three elements": ({"elements": 3}, "elements"),
}


def _cap(**options: Any) -> Cap:
    return Cap(**{"radius": RADIUS, "pressure": PRESSURE, **options})


def _derivative_error(fill: str) -> float:
    """Return the largest error of the derivatives of the equations, relative to the largest of each unknown."""
    cap = _cap(filling=FILLS[fill], elements=10)
    state, balance = cap.press(2e-3), CapBalance(cap, 2e-3)
    noise = 1 + 1e-3 * np.random.default_rng(0).standard_normal(balance.size)
    unknown = balance.packed(state.nodes, state.pressure, state.hand) * noise
    matrix, worst = balance.system(unknown)[1], 0.0
    moving = [k for k in range(balance.size) if k not in balance._fixed]
    for k in moving:
        step = np.zeros(balance.size)
        step[k] = 1e-7 * max(abs(unknown[k]), 1e-3)
        change = (balance.system(unknown + step)[0] - balance.system(unknown - step)[0]) / (2 * step[k])
        off = np.abs(change[moving] - matrix[moving, k])
        worst = max(worst, float((off - 1e-6 * np.abs(matrix[moving, k])).max() / np.abs(matrix[moving, k]).max()))
    return worst


def _work(hand: float) -> tuple[float, float]:
    """Return the energy stored over the work of the hand, and the slope of the forces over the stated slope, around 2 mm."""
    cap, step = _cap(hand=hand), 2e-6
    middle = cap.press(2e-3)
    low, high = cap.press(2e-3 - step, middle), cap.press(2e-3 + step, middle)
    stored = (high.energy - low.energy) / ((low.hand - high.hand) * middle.force)
    return stored, (high.force - low.force) / (2 * step) / middle.stiffness


def _law_of_gas(fill: str) -> float:
    """Return p V^n of the fill after 3 mm over what it was: the volume alone for a liquid."""
    cap, gas = _cap(filling=FILLS[fill], elements=24), FILLS[fill]
    state = cap.press(3e-3)
    room = float(volume(state.nodes).value.sum())
    if not isinstance(gas, Gas):
        return room / cap.volume
    before, after = ((v + gas.below) ** gas.exponent for v in (cap.volume, room))
    return float((AIR + state.pressure) * after / ((AIR + cap.free.pressure) * before))


def _under_a_plate(fill: str) -> list[float]:
    cap, state, forces = _cap(filling=FILLS[fill], hand=PLATE), None, []
    for drop in (2e-3, 4e-3, 6e-3):
        state = cap.press(drop, state)
        forces.append(state.force)
    return forces


def _there_and_back() -> float:
    cap = _cap()
    return cap.press(2e-3, cap.press(4e-3)).force / cap.press(2e-3).force


def _own_units() -> float:
    """Return the force of a cap over the force of a cap of radius and pressure 1, in its units."""
    other = Cap(1.0, 1.0, hand=HAND * RADIUS / PRESSURE)
    return _cap().press(0.05 * RADIUS).force / (PRESSURE * RADIUS**2) / other.press(0.05).force


def _errors_of_the_mesh(drop: float) -> list[float]:
    """Return the errors of forces on 24, 48, 96 and 192 elements against their limit."""
    forces = [_cap(elements=n).press(drop).force for n in (24, 48, 96, 192)]
    right = forces[-1] + (forces[-1] - forces[-2]) / 3
    return [abs(force / right - 1) for force in forces]


def _fall_by_squares(errors: list[float]) -> bool:
    return errors[0] < 0.015 and errors[1] < 0.005 and errors[2] < 0.4 * errors[1] and errors[3] < 0.35 * errors[2]


def _inflated() -> tuple[list[float], list[float]]:
    """Return how far the inflated cap is from a sphere, and its pressure from the given one, on ever finer meshes."""
    free = [_cap(elements=n).free for n in (24, 48, 96)]
    away = [float(np.abs(np.hypot(*f.nodes.T) / RADIUS - 1).max()) for f in free]
    return away, [abs(f.pressure / PRESSURE - 1) for f in free]


def _a_sphere(found: tuple[list[float], list[float]]) -> bool:
    away, wrong = found
    rates = all(a / b > 3.3 for a, b in pairwise(away))
    return away[2] < 2e-4 and rates and all(abs(a / b / 4 - 1) < 0.02 for a, b in pairwise(wrong))


def _between_rows(kappa: float) -> list[float]:
    """Return the force of the table over the force of the solver, between its rows."""
    cap, found = read_table().at(kappa), []
    coarse, fine = (Cap(1.0, 1.0, hand=kappa, elements=n) for n in (96, 192))
    a = b = None
    for drop in (0.15 * cap.limit, 0.5 * cap.limit, 0.9 * cap.limit):
        a, b = coarse.press(drop, a), fine.press(drop, b)
        found.append(cap.force(drop)[0] / (b.force + (b.force - a.force) / 3))
    return found


def _softened_by_gas(beta: float) -> list[float]:
    """Return the force on a gas by the table over the force by the solver."""
    cap, gas, found = read_table().at(2.0), Gas(cap_volume(1.0), 1.0, 2 / beta - 1), []
    for drop in (0.05, 0.12):
        liquid, soft = (Cap(1.0, 1.0, hand=2.0, filling=f, elements=96).press(drop).force for f in (Liquid(), gas))
        found.append(liquid / (1 + beta * cap.yields(drop)[0]) / soft)
    return found


CASES: tuple[Hard, ...] = (
    *group(
        "a cap of no size, a slack one, or one with too few rings",
        {name: (partial(_cap, **options), Refusal(InvalidInput, said)) for name, (options, said) in WRONG.items()},
    ),
    *group(
        "a drop below nothing, past the rim, or past the last equilibrium",
        {
            "a drop below 0": (lambda: _cap().press(-1e-3), Refusal(InvalidInput, "drop")),
            "a drop of the height": (lambda: _cap().press(RADIUS), Refusal(InvalidInput, "drop")),
            "a drop that is no number": (lambda: _cap().press(math.nan), Refusal(InvalidInput, "drop")),
            "a drop without equilibrium": (
                lambda: _cap(elements=24).press(0.9 * RADIUS),
                Refusal(NoEquilibrium, "no equilibrium past a drop of .* mm"),
            ),
            "no drop": (
                lambda: _cap().press(0.0),
                Check("no force, slope or contact", lambda s: (s.force, s.stiffness, s.contact_radius) == (0.0,) * 3),
            ),
            "few rounds of Newton": (lambda: _cap().press(4e-3), Range(2, 40, of=lambda state: state.iterations)),
            "there and back": (_there_and_back, Value(1.0, abs=1e-7)),
            "in its own units": (_own_units, Value(1.0, abs=1e-8)),
        },
    ),
    *group(
        "Newton's method fails where the equations and their derivatives do not belong together",
        {f"derivatives, {fill}": (partial(_derivative_error, fill), Value(0.0, abs=1e-7)) for fill in FILLS},
        {
            f"energy and slope under {name}": (partial(_work, hand), Value((1.0, 1.0), abs=1e-4))
            for name, hand in (("a soft hand", HAND), ("a plate", PLATE))
        },
    ),
    *group(
        "a fill that keeps its volume, its pressure, or neither",
        {f"the room of the fill, {fill}": (partial(_law_of_gas, fill), Value(1.0, abs=1e-9)) for fill in FILLS},
        {
            f"under a plate, {fill}": (partial(_under_a_plate, fill), Value(forces, rel=0.05, abs=0.005))
            for fill, forces in KNOWN.items()
        },
    ),
    *group(
        "the contact ends between two nodes, wherever they are",
        {
            "the inflated cap is a sphere": (
                _inflated,
                Check("off by the square of the element", _a_sphere),
            ),
        },
        {
            f"meshes at {1e3 * drop:g} mm": (
                partial(_errors_of_the_mesh, drop),
                Check("off by the square of the element", _fall_by_squares),
            )
            for drop in (1.5e-3, 3e-3, 4e-3)
        },
    ),
    *group(
        "the table of solved caps has ends, and gaps between its rows",
        {
            f"between rows, kappa {kappa:g}": (partial(_between_rows, kappa), Value([1.0] * 3, abs=0.003))
            for kappa in (1.3, 1.95, 3.9, 11.0)
        },
        {
            f"a gas of softness {beta:g}": (partial(_softened_by_gas, beta), Value([1.0] * 2, abs=error))
            for beta, error in ((0.02, 0.004), (0.08, 0.02))
        },
        {
            "past the hardest row": (
                lambda: read_table().at(1e9).force(0.1),
                Value(read_table().at(256.0).force(0.1)),
            ),
            "past the softest row": (
                lambda: read_table().at(1e-9).force(0.1),
                Value(read_table().at(0.25).force(0.1)),
            ),
            "kappa 0": (lambda: read_table().at(0.0), Refusal(InvalidInput, "kappa")),
        },
    ),
    *group(
        "a power law between points has no logarithm at 0",
        {
            f"a curve at {at:g}": (
                partial(PowerCurve(np.array([1.0, 2.0]), np.array([1.0, 4.0])), at),
                Value((0.0, 0.0)),
            )
            for at in (0.0, -1.0)
        },
        {
            f"a power law at {at:g}": (
                partial(PowerCurve(np.geomspace(0.1, 1.0, 5), 3 * np.geomspace(0.1, 1.0, 5) ** 1.6), at),
                Value((3 * at**1.6, 4.8 * at**0.6), rel=1e-9),
            )
            for at in (1e-3, 0.23, 0.5, 40.0)
        },
    ),
)
