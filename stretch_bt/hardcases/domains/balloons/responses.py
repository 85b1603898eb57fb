"""How fills give way: held, let go, pressed ten thousand times, suddenly, and for ever."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from itertools import pairwise
from typing import Any

from stretch_bt.errors import InvalidInput
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.simulation.balloons.compacting import Compacting
from stretch_bt.simulation.balloons.elastic import Elastic
from stretch_bt.simulation.balloons.laws import hertz, linear, no_force, scaled, together
from stretch_bt.simulation.balloons.lessened import Lessened
from stretch_bt.simulation.balloons.relaxing import Relaxing
from stretch_bt.simulation.balloons.softened import Softened
from stretch_bt.simulation.coupling import couple

RADIUS, TIME = 0.03, 2.0
SKIN, GEL = hertz(50e3, RADIUS), hertz(20e3, RADIUS)
BODY = Elastic(together(SKIN, GEL))
#: each kind of response, and the length of its memory, s
RESPONSES: dict[str, Any] = {
    "elastic": BODY,
    "lessened": Lessened(BODY, hertz(5e3, RADIUS)),
    "softened": Softened(BODY, SKIN, 0.2),
    "compacting": Compacting(BODY, 3.0),
    "relaxing": Relaxing(BODY, GEL, TIME),
    "relaxing and softened": Relaxing(Softened(BODY, SKIN, 0.2), GEL, TIME),
    "relaxing and compacting": Relaxing(Compacting(BODY, 3.0), GEL, TIME),
}
MEMORIES = {
    "elastic": None,
    "lessened": None,
    "softened": math.inf,
    "compacting": math.inf,
    "relaxing": 0.05,
    "relaxing and softened": 0.05,
}
ALONE = Relaxing(Elastic(SKIN), GEL, TIME)


def after(response: Any, path: Iterable[tuple[float, float]], state: Any = None) -> Any:
    """Return the state after drops, m, each in a time, s."""
    state = response.start() if state is None else state
    for drop, dt in path:
        state = response.after(state, drop, dt)
    return state


def _held(steps: int) -> float:
    """Return the force of a gel held for 3 s, in so many steps, over what it should be."""
    drop = 2e-3
    state = after(ALONE, [(drop, 0.0)] + [(drop, 3.0 / steps)] * steps)
    right = SKIN(drop)[0] + GEL(drop)[0] * math.exp(-3.0 / TIME)
    return float(ALONE.law(state, 0.0)(drop)[0] / right)


def _sudden_and_slow() -> list[float]:
    drop = 2e-3
    sudden, slow = (ALONE.law(ALONE.start(), dt)(drop)[0] for dt in (0.0, 1e6))
    return [sudden / (SKIN(drop)[0] + GEL(drop)[0]), slow / SKIN(drop)[0]]


def _ramp_errors() -> list[float]:
    """Return errors of an even press in 20, 40 and 80 steps, against q = int g'(s) exp(-(T - s) / time) ds."""
    from scipy.integrate import quad

    speed, end = 1e-3, 2.0
    right = quad(lambda s: GEL(speed * s)[1] * speed * math.exp((s - end) / TIME), 0, end, epsabs=1e-12)[0]
    response: Any = Relaxing(Elastic(no_force), GEL, TIME)
    paths = [[(speed * end * (k + 1) / n, end / n) for k in range(n)] for n in (20, 40, 80)]
    return [abs(after(response, path).branch / right - 1) for path in paths]


def _comes_back() -> tuple[list[float], float]:
    """Return how far a gel that was held down stays down after ever longer times, and where it is after 20 s, m."""
    response = RESPONSES["relaxing"]
    held = after(response, [(3e-3, 0.0), (3e-3, 10.0)])
    rests = [response.rest(held, dt) for dt in (0.0, 0.1, 1.0, 10.0, 1e6)]
    return rests, after(response, [(0.0, 0.05)] * 400, held).drop


def _is_back(found: tuple[list[float], float]) -> bool:
    rests, drop = found
    falls = all(b < a for a, b in pairwise(rests))
    return falls and 0 < rests[0] < 3e-3 and rests[-1] < 1e-6 and drop < 1e-4


def _cycled(name: str) -> bool:
    """Whether ten thousand cycles change nothing after the first."""
    response = RESPONSES[name]
    first = after(response, [(3e-3, 0.01), (0.0, 0.01)])
    return bool(after(response, [(3e-3, 0.01), (0.0, 0.01), (2.9e-3, 0.01)] * 10_000, first) == first)


def _grains() -> list[float]:
    """Return the work that grains lose, the drop that stays, and force and slope just before the largest drop, each as a part."""
    response, deepest, count = RESPONSES["compacting"], 3e-3, 4000
    law = response.law(state := response.after(response.start(), deepest, 0.0), 0.0)
    loading, unloading = (sum(f(deepest * (k + 0.5) / count)[0] for k in range(count)) for f in (BODY.by_drop, law))
    force, slope = law(deepest * (1 - 1e-9))
    there = BODY.by_drop(deepest)
    return [1 - unloading / loading, response.rest(state, 0.0) / deepest, force / there[0], slope / there[1]]


def _softer() -> list[float]:
    """Return forces of softened rubber over the forces of virgin rubber, below its largest drop, at it and past it."""
    law = RESPONSES["softened"].law(after(RESPONSES["softened"], [(3e-3, 0.0)]), 0.0)
    below = BODY.by_drop(1e-3)[0] - 0.2 * (2 / 3) * SKIN(1e-3)[0]
    return [law(1e-3)[0] / below, *(law(d)[0] / BODY.by_drop(d)[0] for d in (3e-3, 4e-3))]


def _memory(name: str) -> float | None:
    memory: float | None = RESPONSES[name].memory
    return memory


def _met(name: str, exponent: float) -> float:
    """Return by how much forces differ where a membrane and a response that was pressed before meet, as a part."""
    response, travel = RESPONSES[name], 0.02
    state = after(response, [(0.008, 0.05), (0.002, 1.0)])
    law, rest = response.law(state, 0.05), response.rest(state, 0.05)
    factor = 10**exponent * BODY.by_drop(travel)[0] / travel**1.5

    def membrane(depth: float) -> tuple[float, float]:
        root = math.sqrt(max(depth, 0.0))
        return factor * root * max(depth, 0.0), 1.5 * factor * root

    found = couple(membrane, law, travel, rest=rest, kinks=response.kinks(state))
    assert found.drop >= rest * (1 - 1e-9)
    return float(abs(law(found.drop)[0] / membrane(found.depth)[0] - 1) + abs((found.drop + found.depth) / travel - 1))


CASES: tuple[Hard, ...] = (
    *group(
        "a hold may be divided into any steps, be sudden, or last for ever",
        {f"a held gel, {steps} steps": (partial(_held, steps), Value(1.0, abs=1e-10)) for steps in (1, 7, 100)},
        {
            "sudden and slow": (_sudden_and_slow, Value([1.0, 1.0], abs=1e-5)),
            "a ramp in ever smaller steps": (
                _ramp_errors,
                Check("off by the square of the step", lambda e: e[0] < 1e-3 and e[1] < e[0] / 3 and e[2] < e[1] / 3),
            ),
            "held down and let go": (_comes_back, Check("comes back, all of it in the end", _is_back)),
        },
    ),
    *group(
        "a response that remembers its largest drop must not creep with each cycle",
        {f"ten thousand cycles, {name}": (partial(_cycled, name), Value(True)) for name in ("compacting", "softened")},
        {
            "grains lose two thirds of the work, and stay down by as much": (
                _grains,
                Value([2 / 3, 2 / 3, 1.0, 3.0], abs=1e-4),
            ),
            "softened rubber": (_softer, Value([1.0] * 3, abs=1e-9)),
        },
    ),
    *group(
        "after any path a response balances the membrane, be it far stiffer or far softer",
        {
            f"in series, {name}, 1e{exponent:g}": (partial(_met, name, exponent), Value(0.0, abs=1e-6))
            for name in RESPONSES
            for exponent in (-3.0, 0.0, 3.0)
        },
    ),
    *group(
        "a number that makes no step of time",
        {
            f"a step of {dt:g} s": (
                partial(ALONE.law, ALONE.start(), dt),
                Refusal(InvalidInput, "time step"),
            )
            for dt in (-1.0, math.nan, math.inf)
        },
    ),
    *group(
        "the world steps only a response that remembers, and as finely as it needs",
        {f"memory, {name}": (partial(_memory, name), Value(memory)) for name, memory in MEMORIES.items()},
        {
            "laws add and scale": (
                partial(scaled(together(linear(2.0), linear(3.0)), 10.0, 0.5), 0.25),
                Value((25.0, 100.0), rel=1e-9),
            ),
            "no force": (partial(no_force, 1.0), Value((0.0, 0.0))),
        },
    ),
)
