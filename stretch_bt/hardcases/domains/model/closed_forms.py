"""Formulas outside of their range: Hertz, two elastic bodies, a ratio of numbers that may be zero, heights, roots."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import (
    cube_yield_stress,
    estimate_stiffness,
    hertz_depth,
    hertz_force,
    object_modulus,
    undeformed_height,
)
from stretch_bt.model.root import rising_root
from stretch_bt.units import Estimate

BALL = {"radius": 0.01}
#: shape, sizes, modulus of the object, and the paper's formula written out with numbers; depth 10 mm, E* 6 kPa, v 0.5
PRINTED: dict[str, tuple[str, dict[str, float], float, float]] = {
    "sphere": ("sphere", BALL, math.inf, 4 / 3 * math.sqrt(0.01**3 * 0.01) / (0.75 / 6e3)),
    "soft sphere": ("sphere", BALL, 50e3, 4 / 3 * math.sqrt(0.01**3 * 0.01) / (0.75 / 6e3 + 0.75 / 50e3)),
    "cylinder": ("cylinder", BALL, math.inf, 2 * 0.01 * 0.01 * 6e3),
    "cone": ("cone", {"angle": math.pi / 4}, math.inf, 2 * 0.01**2 * 6e3 / (math.pi * 0.75)),
}
#: shape, depth, modulus, sizes, and a pattern of the refusal
WRONG: dict[str, tuple[str, Any, float, dict[str, float], str]] = {
    "a cube": ("cube", 0.01, 6e3, BALL, "sphere, cylinder, cone"),
    "a depth below 0": ("sphere", -0.01, 6e3, BALL, "depth must be at least 0 m"),
    "a depth NaN": ("sphere", math.nan, 6e3, BALL, "depth must be finite"),
    "a depth that is text": ("sphere", "deep", 6e3, BALL, "depth must be real numbers, m, not"),
    "a modulus of 0": ("sphere", 0.01, 0.0, BALL, "modulus must be above 0 Pa"),
    "a sphere without radius": ("sphere", 0.01, 6e3, {}, "a sphere needs radius"),
    "a radius of 0": ("sphere", 0.01, 6e3, {"radius": 0.0}, "radius must be above 0 m"),
    "a radius below 0": ("sphere", 0.01, 6e3, {"radius": -0.01}, "radius must be above 0 m"),
    "an infinite radius": ("sphere", 0.01, 6e3, {"radius": math.inf}, "radius must be finite"),
    "a sphere with an angle": ("sphere", 0.01, 6e3, {**BALL, "angle": 0.5}, "no angle"),
    "a Poisson's ratio of 0.6": ("sphere", 0.01, 6e3, {**BALL, "poisson": 0.6}, "poisson must lie"),
    "an object of no modulus": (
        "sphere",
        0.01,
        6e3,
        {**BALL, "object_modulus": 0.0},
        "object_modulus must be above 0 Pa",
    ),
    "a soft cylinder": ("cylinder", 0.01, 6e3, {**BALL, "object_modulus": 1e5}, "the cylinder is rigid"),
    "a cone with a radius": ("cone", 0.01, 6e3, BALL, "a cone needs angle"),
    "a cone of 90 degrees": ("cone", 0.01, 6e3, {"angle": math.pi / 2}, "between 0 and pi/2"),
    "a cone of 0 degrees": ("cone", 0.01, 6e3, {"angle": 0.0}, "angle must be above 0 rad"),
}
PRESS = (Estimate(1.2, 0.02), Estimate(0.002, 1e-4), Estimate(0.008, 1e-4), Estimate(0.03, 1e-3))
#: which of force, deflection, depth and radius is another one
NO_MODULUS: dict[str, tuple[int, Estimate, type[Exception]]] = {
    "a deflection as large as its deviation": (1, Estimate(1e-4, 1e-4), IllConditioned),
    "a deflection below 0": (1, Estimate(-1e-4, 1e-6), IllConditioned),
    "no force": (0, Estimate(0.0, 0.0), IllConditioned),
    "no radius": (3, Estimate(0.0, 0.0), InvalidInput),
    "an infinite radius": (3, Estimate(math.inf, 0.0), InvalidInput),
    "a depth NaN": (2, Estimate(math.nan, 0.0), InvalidInput),
}
FLOWING, EDGE, UNDER = Estimate(4.5, 0.1), Estimate(0.025, 2e-4), Estimate(0.0225, 0.0)
NO_YIELD_STRESS: dict[str, tuple[Estimate, Estimate, type[Exception]]] = {
    "a force as large as its deviation": (Estimate(0.1, 0.1), EDGE, IllConditioned),
    "an edge as large as its deviation": (FLOWING, Estimate(0.025, 0.02), IllConditioned),
    "no force": (Estimate(0.0, 0.0), EDGE, IllConditioned),
    "a force below 0": (Estimate(-1.0, 0.1), EDGE, InvalidInput),
    "no edge": (FLOWING, Estimate(0.0, 0.0), InvalidInput),
    "an edge NaN": (FLOWING, Estimate(math.nan, 0.0), InvalidInput),
    "an edge of the smallest double": (FLOWING, Estimate(5e-324, 0.0), InvalidInput),
}
FORCE, DROP = Estimate(1.0, 0.01), Estimate(1e-3, 1e-5)
NO_STIFFNESS: dict[str, tuple[Estimate, Estimate, Refusal]] = {
    "no deflection": (FORCE, Estimate(0.0, 0.0), Refusal(IllConditioned, "too little to tell")),
    "a deflection below 0": (FORCE, Estimate(-1e-3, 1e-5), Refusal(IllConditioned, "too little to tell")),
    "a deflection of 3 deviations": (FORCE, Estimate(3e-4, 1e-4), Refusal(IllConditioned, "too little to tell")),
    "a force NaN": (Estimate(math.nan, 0.1), DROP, Refusal(InvalidInput)),
    "a deviation below 0": (Estimate(1.0, -0.1), DROP, Refusal(InvalidInput)),
    "a deviation without end": (Estimate(1.0, 0.1), Estimate(1e-3, math.inf), Refusal(InvalidInput)),
    "a force below 0": (Estimate(-1.0, 0.1), DROP, Refusal(InvalidInput)),
}
#: depths and heights, m, deviations, m, and the error
NO_HEIGHT: dict[str, tuple[list[float], list[float], list[float], type[Exception]]] = {
    "one press": ([1e-3], [0.06], [1e-4], IllConditioned),
    "two presses to one depth": ([2e-3, 2e-3], [0.06, 0.06], [1e-4, 1e-4], IllConditioned),
    "no depth": ([0.0, 0.0], [0.06, 0.06], [1e-4, 1e-4], IllConditioned),
    "a height less": ([1e-3, 2e-3], [0.06], [1e-4, 1e-4], InvalidInput),
    "a depth NaN": ([1e-3, math.nan], [0.06, 0.06], [1e-4, 1e-4], InvalidInput),
    "a depth below 0": ([1e-3, -2e-3], [0.06, 0.06], [1e-4, 1e-4], InvalidInput),
    "no deviation": ([1e-3, 2e-3], [0.06, 0.06], [1e-4, 0.0], InvalidInput),
}
DEPTHS = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])


def _replaced(place: int, value: Estimate) -> Estimate:
    return object_modulus(*(value if k == place else given for k, given in enumerate(PRESS)))


def _back(shape: str, sizes: dict[str, float], depth: float) -> float:
    """Return the depth computed back from the force at a depth, over that depth."""
    force = float(hertz_force(shape, depth, 5e3, **sizes))
    return float(hertz_depth(shape, force, 5e3, **sizes)) / depth


def _modulus_again(modulus: float) -> float:
    """Return the modulus of an object as computed from its own force, over the true one."""
    membrane, radius, both = 6e3, 0.03, 0.01
    force = float(hertz_force("sphere", both, membrane, radius=radius, object_modulus=modulus))
    depth = (force * 0.75 / (4 / 3 * membrane * math.sqrt(radius))) ** (2 / 3)
    told = object_modulus(*(Estimate(v, 0.0) for v in (force, both - depth, depth, radius)))
    return told.value / modulus


def _drawn(draw: Callable[[np.random.Generator, Estimate], Estimate], count: int) -> float:
    """Return the stated deviation of a modulus over the deviation of the moduli of many draws."""
    random = np.random.default_rng(3)
    values = [object_modulus(*(draw(random, e) for e in PRESS)).value for _ in range(count)]
    return object_modulus(*PRESS).sd / float(np.std(values))


def _one(random: np.random.Generator, estimate: Estimate) -> Estimate:
    return Estimate(random.normal(estimate.value, estimate.sd), 0.0)


def _stated(correlation: float) -> float:
    """Return the stated deviation of a stiffness over the deviation of the ratios of many draws of force and deflection."""
    random, force, drop = np.random.default_rng(2), Estimate(1.35, 0.04), Estimate(1.5e-3, 4e-5)
    shared = correlation * force.sd * drop.sd
    spread = [[force.sd**2, shared], [shared, drop.sd**2]]
    drawn = random.multivariate_normal([force.value, drop.value], spread, 20000)
    return estimate_stiffness(force, drop, correlation).sd / float(np.std(drawn[:, 0] / drawn[:, 1]))


def _spread_of_heights(c: float) -> float:
    """Return the root mean square of the error of a height over its deviation, for an object that gives way so."""
    random, sds, ratios = np.random.default_rng(2), np.array([1e-4, 2e-4, 1e-4, 2e-4, 1e-4]), []
    for _ in range(600):
        found = undeformed_height(DEPTHS, 0.06 - c * DEPTHS**1.5 + random.normal(0, sds), sds)
        ratios.append((found.value - 0.06) / found.sd)
    return math.sqrt(float(np.mean(np.square(ratios))))


CASES: tuple[Hard, ...] = (
    *group(
        "the formulas as they are printed hold at no depth, from a nanometre on, and for any modulus",
        {
            f"{name}, as printed": (
                partial(hertz_force, shape, 0.01, 6e3, object_modulus=modulus, **sizes),
                Value(force, rel=1e-14),
            )
            for name, (shape, sizes, modulus, force) in PRINTED.items()
        },
        {
            f"{shape}, no depth": (partial(hertz_force, shape, 0.0, 5e3, **sizes), Value(0.0))
            for shape, sizes in (("sphere", BALL), ("cylinder", BALL), ("cone", {"angle": 0.5}))
        },
        {
            f"{shape}, {depth:g} m there and back": (partial(_back, shape, sizes, depth), Value(1.0, abs=1e-12))
            for shape, sizes in (("sphere", BALL), ("cylinder", BALL), ("cone", {"angle": 0.5}))
            for depth in (1e-9, 0.1)
        },
        {
            f"an object of {modulus:g} Pa": (partial(_modulus_again, modulus), Value(1.0, abs=1e-6))
            for modulus in (1e3, 1e5, 1e7)
        },
        prefix="hertz, ",
    ),
    *group(
        "a shape, a size or a modulus that the formula does not hold for",
        {
            name: (partial(hertz_force, shape, depth, modulus, **sizes), Refusal(InvalidInput, said))
            for name, (shape, depth, modulus, sizes, said) in WRONG.items()
        },
        {
            "a force below 0": (
                partial(hertz_depth, "sphere", -1.0, 6e3, radius=0.01),
                Refusal(InvalidInput, "force must be at least 0 N"),
            ),
        },
        prefix="hertz, ",
    ),
    *group(
        "an object that gave way by less than its error has no modulus",
        {name: (partial(_replaced, at, value), Refusal(error)) for name, (at, value, error) in NO_MODULUS.items()},
        {"deviation of draws": (partial(_drawn, _one, 4000), Value(1.0, abs=0.05))},
        prefix="modulus, ",
    ),
    *group(
        "a force or an edge within its error gives no yield stress; the deviation counts force and edge",
        {
            name: (partial(cube_yield_stress, force, edge, UNDER), Refusal(error))
            for name, (force, edge, error) in NO_YIELD_STRESS.items()
        },
        {
            "a density of 0": (
                partial(cube_yield_stress, FLOWING, EDGE, UNDER, density=0.0),
                Refusal(InvalidInput, "density"),
            ),
            **{
                f"pressed by {lost:g} of its height": (
                    partial(cube_yield_stress, FLOWING, EDGE, Estimate(0.025 * (1 - lost), 0.0)),
                    Refusal(IllConditioned, "of its height"),
                )
                for lost in (-0.01, 0.0, 0.01, 0.5)
            },
            "of a cube of the scene": (
                partial(cube_yield_stress, FLOWING, EDGE, UNDER),
                Value(5.18e3, rel=0.01, of=lambda found: found.value),
            ),
            "deviation of an edge of 2 %": (
                partial(cube_yield_stress, Estimate(4.5, 0.0), Estimate(0.025, 5e-4), UNDER),
                Value(0.0494, rel=0.02, of=lambda found: found.sd / found.value),
            ),
        },
        prefix="yield stress, ",
    ),
    *group(
        "force and deflection of a ratio may both be zero within their errors, and the errors may be correlated",
        {name: (partial(estimate_stiffness, f, d), refusal) for name, (f, d, refusal) in NO_STIFFNESS.items()},
        {
            f"a correlation of {c:g}": (partial(estimate_stiffness, FORCE, DROP, c), Refusal(InvalidInput, "together"))
            for c in (-1.1, 1.1, math.nan)
        },
        {
            f"deviation with a correlation of {c:g}": (partial(_stated, c), Value(1.0, abs=0.06))
            for c in (-0.9, 0.0, 0.9)
        },
        prefix="stiffness, ",
    ),
    *group(
        "the height at no force is extrapolated, from presses that may be equal or of a rigid object",
        {name: (partial(undeformed_height, d, h, sd), Refusal(error)) for name, (d, h, sd, error) in NO_HEIGHT.items()},
        {
            "heights that rise with depth": (
                partial(undeformed_height, [1e-3, 5e-3], [0.06, 0.061], [1e-3, 1e-3]),
                Value(0.0605, rel=1e-6, of=lambda found: found.value),
            ),
            "error over deviation, soft": (partial(_spread_of_heights, 1.5), Range(0.85, 1.15)),
            "error over deviation, rigid": (partial(_spread_of_heights, 0.0), Range(0.65, 1.0)),
        },
        {
            f"exact, {c:g}": (
                partial(undeformed_height, DEPTHS, 0.06 - c * DEPTHS**1.5, np.full(5, 1e-4)),
                Value(0.06, abs=1e-12, of=lambda found: found.value),
            )
            for c in (0.0, 0.01, 5.0)
        },
        prefix="height, ",
    ),
    *group(
        "a root outside the bracket, or at a jump",
        {
            "below": (partial(rising_root, lambda x: x + 2, 0.0, 1.0), Value(0.0)),
            "above": (partial(rising_root, lambda x: x - 2, 0.0, 1.0), Value(1.0)),
            "a jump": (partial(rising_root, lambda x: math.copysign(1.0, x - 0.3), 0.0, 1.0), Value(0.3, abs=1e-9)),
            "flat": (
                partial(rising_root, lambda x: (x - 0.3) ** 5 + 1e-3 * (x - 0.3), -1.0, 1.0),
                Value(0.3, abs=1e-9),
            ),
        },
        prefix="root, ",
    ),
)
