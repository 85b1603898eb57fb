"""Objects of any law against membranes of any power, and inputs that are no law, travel or rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.coupling import Equilibrium, couple
from stretch_bt.simulation.objects.buckling import BucklingResponse
from stretch_bt.simulation.objects.response import Law, LinearResponse
from stretch_bt.simulation.objects.roof import RoofOnWalls, RoofResponse
from stretch_bt.simulation.solve import Root, find_root

TRAVEL = 0.012
KINDS = ("elastic", "stiffening", "softening", "plastic", "hardening", "viscous", "buckling")
RISING, FALLING = BucklingResponse(1e4, 1.0), BucklingResponse(1e4, 1.0, fall=0.4, over=5e-4)
Objects = tuple[Law, tuple[float, ...]]


def power(factor: float, exponent: float = 1.5) -> Law:
    """Return the law of a power of the travel."""
    return lambda d: (factor * d**exponent, exponent * factor * d ** (exponent - 1)) if d > 0 else (0.0, 0.0)


def _plastic(stiffness: float, yield_force: float, hardening: float) -> Law:
    limit = yield_force / stiffness
    return lambda u: (stiffness * u, stiffness) if u < limit else (yield_force + hardening * (u - limit), hardening)


def _viscous(stiffness: float, drag: float, start: float) -> Law:
    """Return the law of one implicit step of a spring and, from `start` on, a dashpot beside it."""
    return lambda u: (stiffness * u + drag * max(u - start, 0.0), stiffness + drag * (u > start))


def buckling(stiffness: float, limit: float, after: float) -> Objects:
    """Return a law that falls from its limit to half of it over as much drop again, and rises from there."""
    top = limit / stiffness

    def law(u: float) -> tuple[float, float]:
        if u < top:
            return stiffness * u, stiffness
        if u < 2 * top:
            return limit * (1.5 - u / (2 * top)), -limit / (2 * top)
        return limit / 2 + after * (u - 2 * top), after

    return law, (top, 2 * top)


def thing(kind: str, stiffness: float) -> Objects:
    """Return the law of an object of about this stiffness, with the drops at which it has a kink."""
    force = stiffness * TRAVEL
    return {
        "elastic": (power(stiffness, 1.0), ()),
        "stiffening": (power(stiffness / TRAVEL**0.6, 1.6), ()),
        "softening": (power(stiffness * TRAVEL**0.5, 0.5), ()),
        "plastic": (_plastic(stiffness, 0.1 * force, 0.0), (0.1 * TRAVEL,)),
        "hardening": (_plastic(stiffness, 0.1 * force, 1e-3 * stiffness), (0.1 * TRAVEL,)),
        "viscous": (_viscous(0.1 * stiffness, 20 * stiffness, 0.2 * TRAVEL), (0.2 * TRAVEL,)),
        "buckling": buckling(stiffness, 0.2 * force, 0.4 * stiffness),
    }[kind]


class _Series(NamedTuple):
    """The worst over 25 ratios of stiffness: of force and travel, as parts, and of evaluations."""

    force: float
    travel: float
    iterations: int


def _series(kind: str, exponent: float) -> _Series:
    """Meet objects from 1e-3 to 1e3 times the membrane's stiffness, against a bisection to the last bit."""
    membrane, worst = power(1.0 / TRAVEL**exponent, exponent), _Series(0.0, 0.0, 0)
    for k in range(25):
        law, kinks = thing(kind, 10 ** (-3 + k / 4) / TRAVEL)
        found = couple(membrane, law, TRAVEL, kinks=kinks)
        force = membrane(TRAVEL - _bisected(membrane, law, kinks, found.drop))[0]
        off = abs(found.force / force - 1), abs((found.depth + found.drop) / TRAVEL - 1)
        worst = _Series(max(worst.force, off[0]), max(worst.travel, off[1]), max(worst.iterations, found.iterations))
    return worst


def _bisected(membrane: Law, law: Law, kinks: tuple[float, ...], drop: float) -> float:
    """Return the drop at which forces agree, on the piece between kinks on which one was found."""
    high = next(k for k in (*kinks, TRAVEL) if k >= drop * (1 - 1e-12))
    low = max((k for k in kinks if k < high), default=0.0)
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if membrane(TRAVEL - middle)[0] > law(middle)[0] else (low, middle)
    return (low + high) / 2


def _snapped(travel: float, before: float | None = None) -> Equilibrium:
    """Press an object that buckles by a soft membrane, from where it was at another travel."""
    law, kinks = buckling(1000.0, 1.0, 1000.0)
    membrane = power(200.0, 1.0)
    start = None if before is None else _snapped(before).drop
    return couple(membrane, law, travel, kinks=kinks, start=start)


def _back() -> Equilibrium:
    law, kinks = buckling(1000.0, 1.0, 1000.0)
    return couple(power(200.0, 1.0), law, 0.0058, kinks=kinks, start=_snapped(0.0061, 0.0058).drop)


def _within_a_fall() -> float:
    """Return by how much an equilibrium on a falling piece is missed, over the travel, against a scan in small steps."""
    membrane, travel = power(1471.0), 6.785e-3
    response = BucklingResponse(430.0, 0.584, 0.4, 0.890, 3.905e-3)
    law = response.law(response.start(), 0.0)
    found = couple(membrane, law, travel, kinks=response.kinks(response.start()))
    drops = (travel * k / 20000 for k in range(1, 20000))
    first = next(d for d in drops if membrane(travel - d)[0] <= law(d)[0])
    return (found.drop - first) / travel


def _springs(rest: float = 0.0) -> float:
    """Return the force of two springs in series, one of which stays down by `rest`."""
    if not rest:
        return couple(power(300.0, 1.0), LinearResponse(900.0).law(None, 0.0), TRAVEL).force
    return couple(power(300.0, 1.0), lambda u: (900 * max(u - rest, 0.0), 900.0), TRAVEL, rest=rest).force


def _rough(low_force: float) -> tuple[float, int]:
    """Return by how much a drop is off, over the travel, where the force of the membrane jumps just there; and evaluations."""

    def law(drop: float) -> tuple[float, float]:
        return low_force + 300.0 * drop, 300.0

    smooth = couple(power(100.0, 1.2), law, TRAVEL)

    def rough(depth: float) -> tuple[float, float]:
        force, slope = power(100.0, 1.2)(depth)
        return force * (1 + math.copysign(1e-3, depth - smooth.depth)), slope

    found = couple(rough, law, TRAVEL, kinks=(1e-9,), close=1e-5)
    return (found.drop - smooth.drop) / TRAVEL, found.iterations


def _at_kink(by: float, start: float | None) -> Equilibrium:
    """Press an object that unloads three times as stiff to where it was, by a membrane whose force there is off by a part."""
    membrane, largest = power(100.0 * (1 + by)), 2e-3
    force = power(100.0)(TRAVEL - largest)[0]

    def law(drop: float) -> tuple[float, float]:
        stiffness = force / largest * (1 if drop >= largest else 3)
        return max(force + stiffness * (drop - largest), 0.0), stiffness

    return couple(membrane, law, TRAVEL, rest=largest * 2 / 3, start=start, kinks=(largest,))


def _two_powers(exponent: float, power_: float, other: float, travel: float) -> Equilibrium:
    law = power(10**exponent / travel**other, other)
    found = couple(power(1.0 / travel**power_, power_), law, travel)
    assert abs(law(found.drop)[0] / found.force - 1) < 1e-6
    return found


def _through_walls(stiffness: float, travel: float) -> tuple[float, float]:
    """Return the forces that a membrane and paper walls differ by, and the travel, each as a part."""
    found = couple(lambda d: (stiffness * d, stiffness), RISING.law(None, 0.0), travel, kinks=RISING.kinks(None))
    return stiffness * found.depth / RISING.force(found.drop)[0] - 1, (found.depth + found.drop) / travel - 1


def _snap_through() -> Equilibrium:
    soft = 200.0
    travel = 1.0 / soft + FALLING.buckled + 1e-5
    return couple(lambda d: (soft * d, soft), FALLING.law(None, 0.0), travel, start=0.0, kinks=FALLING.kinks(None))


def _flat_root(value: float) -> Callable[[float], tuple[float, float]]:
    return lambda x: (value, value)


def _far_root() -> Root:
    return find_root(lambda x: (math.atan(0.3 - x), -1 / (1 + (0.3 - x) ** 2)), -100.0, 90.0, 90.0, "")


def _is_past(found: Equilibrium) -> bool:
    return found.jumped and found.drop > FALLING.buckled + FALLING.over * 0.9 and found.force < FALLING.critical


def _bad_couple(rest: float, travel: float) -> Equilibrium:
    return couple(power(1e3), power(1e3), travel, rest=rest)


WRONG_WALLS: dict[str, dict[str, float]] = {
    "no stiffness": {"stiffness": 0.0},
    "they never buckle": {"critical": math.inf},
    "none after buckling": {"post": 0.0},
    "a fall over nothing": {"fall": 0.5},
    "no fall over something": {"over": 1e-3},
    "a fall to nothing": {"fall": 1.0, "over": 1e-3},
}
#: how far apart exponents may be, and how small the travel
POWERS = (
    (-6.0, 0.5, 3.0, 1e-7),
    (6.0, 0.5, 3.0, 1e-7),
    (-6.0, 3.0, 0.3, 0.03),
    (6.0, 3.0, 0.3, 0.03),
    (0.0, 1.5, 1.0, 1e-7),
)
CLOSE = Check(
    "force within 1e-6, travel within 1e-9, in at most 10 evaluations",
    lambda w: w.force < 1e-6 and w.travel < 1e-9 and w.iterations <= 10,
)

CASES: tuple[Hard, ...] = (
    *group(
        "an object of a thousandth to a thousand times the membrane's stiffness, with kinks, falls and dashpots",
        {
            f"{kind}, membrane of power {exponent:g}": (partial(_series, kind, exponent), CLOSE)
            for kind in KINDS
            for exponent in (1.0, 1.5, 3.0)
        },
        {
            f"powers {a:g} and {b:g}, ratio 1e{exponent:+g}, {travel:g} m": (
                partial(_two_powers, exponent, a, b, travel),
                Check("in at most 12 evaluations", lambda found: found.iterations <= 12),
            )
            for exponent, a, b, travel in POWERS
        },
    ),
    *group(
        "an object whose force falls has several equilibria, and only one is reached on the way",
        {
            "before the limit point": (
                partial(_snapped, 0.0058),
                Check("not jumped, below 1 mm", lambda found: not found.jumped and found.drop < 1e-3),
            ),
            "past the limit point": (
                partial(_snapped, 0.0061, 0.0058),
                Check("jumped, past 2 mm", lambda found: found.jumped and found.drop > 2e-3),
            ),
            "back from past it": (
                _back,
                Check("not jumped, and stays past 2 mm", lambda found: not found.jumped and found.drop > 2e-3),
            ),
            "an equilibrium within a falling piece": (_within_a_fall, Value(0.0, abs=1e-4)),
            "through walls whose force falls": (_snap_through, Check("jumped past the fall", _is_past)),
        },
        {
            f"walls under {stiffness:g} N/m, {travel:g} m": (
                partial(_through_walls, stiffness, travel),
                Value((0.0, 0.0), abs=1e-6),
            )
            for stiffness in (10.0, 300.0, 1e3, 1e5)
            for travel in (1e-5, 1e-3, 1e-2)
        },
    ),
    *group(
        "an object that stays down, holds harder than it is pressed, or begins at a place with a force",
        {
            "two springs": (_springs, Value(TRAVEL / (1 / 300 + 1 / 900), rel=1e-9)),
            "one that stays down": (partial(_springs, 0.004), Value((TRAVEL - 0.004) / (1 / 300 + 1 / 900), rel=1e-9)),
            "one that stays down by more than the travel": (
                lambda: couple(power(300.0, 1.0), power(300.0, 1.0), 0.003, rest=0.004),
                Value((0.0, 0.003, 0.0, 0, False)),
            ),
            "one that holds harder than it is pressed": (
                lambda: couple(power(100.0), lambda u: (5.0 + 300.0 * u, 300.0), TRAVEL, kinks=(1e-9,), rest=1e-3)[1:3],
                Value((1e-3, 100.0 * (TRAVEL - 1e-3) ** 1.5), rel=1e-6),
            ),
        },
    ),
    *group(
        "where nothing has moved since, forces agree at the kink of unloading, and rounding would decide from which side to come to it",
        {
            f"at a kink, {by:+g} of the force, from {'there' if start else 'rest'}": (
                partial(_at_kink, by, start),
                Check(
                    "at the kink in at most 2 evaluations", lambda found: found.drop == 2e-3 and found.iterations <= 2
                ),
            )
            for by in (-1e-15, 0.0, 1e-15)
            for start in (None, 2e-3)
        },
    ),
    *group(
        "a force that jumps has no slope where Newton's method would need one",
        {
            "a jump of the object's force": (
                lambda: couple(power(100.0, 1.0), lambda u: (0.0, 0.0) if u < 0.005 else (5.0, 1.0), TRAVEL).drop,
                Value(0.005, rel=1e-6),
            ),
        },
        {
            f"a jump of the membrane's force where forces agree, from {low:g} N": (
                partial(_rough, low),
                Check("within 1e-5 in fewer than 30 evaluations", lambda found: abs(found[0]) < 1e-5 and found[1] < 30),
            )
            for low in (0.0, 0.3)
        },
    ),
    *group(
        "a travel or a rest that is no length, and laws that give no numbers",
        {
            f"rest {rest:g}, travel {travel:g}": (
                partial(_bad_couple, rest, travel),
                Refusal(InvalidInput, "at least 0 m"),
            )
            for rest, travel in ((0.0, -0.01), (0.0, math.nan), (-1.0, 0.01), (math.inf, 0.01))
        },
        {
            "no convergence": (
                partial(find_root, _flat_root(math.nan), 0.0, 1.0, 0.5, "a case"),
                Refusal(NoEquilibrium, "a case: no convergence"),
            ),
            "Newton's step leaves the bracket": (_far_root, Value(0.3, rel=1e-6, of=lambda root: root.x)),
            "a roof on walls whose force falls": (
                partial(RoofOnWalls, RoofResponse(1.0), FALLING),
                Refusal(InvalidInput, "fall"),
            ),
            "a roof without stiffness": (partial(RoofResponse, 0.0), Refusal(InvalidInput)),
        },
        {
            f"walls, {name}": (
                partial(BucklingResponse, **{"stiffness": 1e4, "critical": 1.0, **wrong}),
                Refusal(InvalidInput),
            )
            for name, wrong in WRONG_WALLS.items()
        },
    ),
)
