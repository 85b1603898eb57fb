"""Palpation of objects that never give way, give way at once, or are read twice at one force: the fit of a series of readings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import ForceModel, TopReading, fit_series
from stretch_bt.model.force.local import local_forces
from stretch_bt.model.palpation.balance import FLATTEST, SAME, STEEPEST, Balance, presses_of
from stretch_bt.model.palpation.law import ObjectLaw
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
RADIUS = Estimate(0.03, 0.0)
TOP, DROP = 0.06, 1.5e-3
#: stretch and depth of the hand past first contact, m: a touch, then presses
POSES = ((0.0, 0.002), (0.0, 0.003), (0.0, 0.004), (0.0, 0.010), (0.02, 0.012))
Law = Callable[[float], float]
Poses = Sequence[tuple[float, float]]


class _Factored:
    """The default model with its force times a factor, or falling with depth where the factor is negative."""

    def __init__(self, factor: float) -> None:
        self.factor, self.range = factor, MODEL.range

    def predict(self, radius: float, stretch: float, depth: float) -> tuple[float, float]:
        force, sd = MODEL.predict(radius, stretch, depth)
        return (1.0 - force, sd) if self.factor < 0 else (self.factor * force, self.factor * sd)


def spring(stiffness: float, power: float = 1.4) -> Law:
    """Return the law of an object whose force over drop is `stiffness`, N/m, at 1.5 mm."""
    return lambda drop: stiffness * DROP * (max(drop, 0.0) / DROP) ** power


def height(law: Law, stretch: float, hand: float) -> float:
    """Return the height of the top at which membrane and object carry the same force, m."""

    def pull(h: float) -> float:
        return MODEL.predict(RADIUS.value, stretch, max(h - hand, 0.0))[0] - law(TOP - h)

    return float(brentq(pull, max(hand, TOP - 0.02), TOP, xtol=1e-14))


def seen(
    law: Law, sd: float = 1e-6, noise: np.random.Generator | None = None, poses: Poses = POSES
) -> list[TopReading]:
    """Return readings of an object, m, with noise of their deviation."""
    found = []
    for stretch, depth in poses:
        off = sd * noise.standard_normal() if noise else 0.0
        found.append(TopReading(stretch, TOP - depth, height(law, stretch, TOP - depth) + off, sd))
    return found


def fit(readings: Sequence[TopReading], **options: Any) -> Any:
    """Return the fit of readings by the default model, but for some options."""
    given: dict[str, Any] = {"model": MODEL, "radius": RADIUS, **options}
    return fit_series(given.pop("model"), given.pop("radius"), readings, **given)


def _exact(stiffness: float, power: float) -> list[float]:
    """Return errors of power, drop and stiffness from exact readings: absolute for the power, relative for the others."""
    law = spring(stiffness, power)
    readings = seen(law, 1e-9)
    found = fit(readings, power=Estimate(power + 0.1, 10.0), stiffening=Estimate(0.0, 1e-3), robot_sd=0.0)
    true = TOP - readings[-1].height
    return [found.power.value - power, found.drop.value / true - 1, found.secant.value / (law(true) / true) - 1]


def _wrong_factor() -> list[float]:
    """Return drop and stiffness by a model that is off by a factor of 0.8, over those by the right one."""
    readings = seen(spring(600.0), 1e-8)
    right, wrong = (fit(readings, model=_Factored(f), robot_sd=0.0) for f in (1.0, 0.8))
    return [wrong.drop.value / right.drop.value, wrong.secant.value / right.secant.value]


def _scattered() -> list[float]:
    """Return chi2 of readings that scatter ten times as much as stated, and the deviation of their drop over that from honest ones."""
    readings = seen(spring(600.0), 2e-4, np.random.default_rng(3), poses=[*POSES, *POSES])
    found = fit([replace(r, sd=2e-5) for r in readings])
    return [found.chi2, found.drop.sd / fit(readings).drop.sd]


def _known_top() -> float:
    law = spring(600.0)
    found = fit(seen(law, poses=[(0.0, 0.012)]), top=Estimate(TOP, 1e-6))
    return float(found.drop.value / (TOP - height(law, 0.0, TOP - 0.012)))


def _shared() -> list[float]:
    """Return deviations with an error that all heights share over those without: of force, drop and stiffness."""
    readings = seen(spring(600.0), 2e-5)
    alone, shared = (fit(readings, common_sd=sd) for sd in (0.0, 3e-4))
    return [getattr(shared, n).sd / getattr(alone, n).sd for n in ("force", "drop", "secant")]


def _soft() -> float:
    """Return by how many deviations the stiffness of an object a thousand times softer than the membrane is off."""
    law = spring(0.3)
    found, true = fit(seen(law, 2e-5)), TOP - height(law, POSES[-1][0], TOP - POSES[-1][1])
    return float(abs(found.stiffness().value - law(true) / true) / found.secant.sd)


def _changed(**options: Any) -> Any:
    readings = options.pop("readings", GOOD)
    return fit(readings, **options)


GOOD = seen(spring(600.0), 5e-5)
LAST = GOOD[-1]
WRONG: dict[str, tuple[dict[str, Any], Refusal]] = {
    "radius 0": ({"radius": Estimate(0.0, 0.0)}, Refusal(InvalidInput, "radius")),
    "radius below 0": ({"radius": Estimate(-0.03, 0.0)}, Refusal(InvalidInput, "radius")),
    "an infinite radius": ({"radius": Estimate(math.inf, 0.0)}, Refusal(InvalidInput, "radius")),
    "radius 500 mm": ({"radius": Estimate(0.5, 0.0)}, Refusal(InvalidInput, "outside the calibrated range")),
    "no reading": ({"readings": []}, Refusal(IllConditioned, "no reading")),
    "one reading": ({"readings": [LAST]}, Refusal(IllConditioned, "at one force")),
    "one reading twice": ({"readings": [LAST, LAST]}, Refusal(IllConditioned, "at one force")),
    "one press": (
        {"readings": [replace(LAST, height=LAST.height - 1e-4 * i) for i in range(3)]},
        Refusal(IllConditioned, "one press"),
    ),
    "a stretch of 300 mm": (
        {"readings": [*GOOD, TopReading(0.3, 0.05, 0.06, 1e-4)]},
        Refusal(InvalidInput, "outside the calibrated range"),
    ),
    "a depth of 40 mm": (
        {"readings": [*GOOD, TopReading(0.0, 0.02, 0.06, 1e-4)]},
        Refusal(InvalidInput, "outside the calibrated range"),
    ),
    "a height NaN": ({"readings": [*GOOD, TopReading(0.0, 0.05, math.nan, 1e-4)]}, Refusal(InvalidInput, "finite")),
    "no deviation": ({"readings": [*GOOD, TopReading(0.0, 0.05, 0.06, 0.0)]}, Refusal(InvalidInput, "above 0 m")),
    "a force that falls with depth": ({"model": _Factored(-1.0)}, Refusal(IllConditioned, "does not grow with depth")),
    "a power without deviation": ({"power": Estimate(1.5, 0.0)}, Refusal(InvalidInput, "power")),
    "a robot's deviation below 0": ({"robot_sd": -1.0}, Refusal(InvalidInput, "robot_sd")),
    "a top without deviation": ({"top": Estimate(0.06, 0.0)}, Refusal(InvalidInput, "top")),
}


def _above(heights: Sequence[tuple[float, float]], top: Estimate | None) -> Any:
    return fit([TopReading(0.0, hand, h, 3e-5) for h, hand in heights], top=top)


def _hardly_off(robot: float) -> list[float]:
    """Return stiffness and deviation by a hand that stands off by so much, m, over those by one that does not."""
    errors = np.array([1, -2, 1, 2, -1, 1]) * 2e-5
    depths = [(0.0, d) for d in (0.002, 0.004, 0.007, 0.010, 0.010, 0.012)]
    readings = [
        replace(r, height=r.height + e, sd=3e-5) for r, e in zip(seen(spring(600.0), poses=depths), errors, strict=True)
    ]
    found, exact = (fit(readings, robot_sd=sd) for sd in (robot, 0.0))
    return [found.secant.value / exact.secant.value, found.secant.sd / exact.secant.sd]


def _at_bound(power: float, bound: float) -> list[float]:
    """Return the power of a fit, and how far its top and compliance are off a fit that is held there."""
    depths = [(0.0, d) for d in (0.002, 0.004, 0.007, 0.010, 0.010, 0.012)]
    readings = [replace(r, sd=3e-5) for r in seen(spring(600.0, power), poses=depths)]
    found = []
    for sd in (20.0, 1e-6):
        fit = Balance(
            local_forces(MODEL, 0.03, readings), readings, None, Estimate(bound, sd), Estimate(0.03, 0.06), 0.0
        )
        fit.solve()
        found.append(fit.q)
    return [float(found[0][2]), *np.abs(found[0][:2] - found[1][:2]).tolist()]


def _at(drop: float) -> Estimate:
    told: Estimate = fit(GOOD).stiffness_at(drop)
    return told


def _presses(poses: Poses) -> Any:
    return presses_of([TopReading(x, hand, hand + 0.01, 1e-4) for x, hand in poses]).tolist()


def _deflected(compliance: float, power: float, stiffening: float) -> list[float]:
    """Return the deflection under shares of a force, and how far the logarithms of the forces there are off."""
    shares = np.log([1e-3, 1.0, 6.0])
    law = ObjectLaw(compliance, power, stiffening)
    drops, _, _ = law.deflection(shares)
    return [law.log_force(float(d))[0] - s for d, s in zip(drops, shares, strict=True)]


CASES: tuple[Hard, ...] = (
    *group(
        "readings that hold no answer: none, one, all at one force, out of range, or not numbers",
        {name: (partial(_changed, **options), refusal) for name, (options, refusal) in WRONG.items()},
        {
            f"stiffness at a drop of {drop:g} m": (
                partial(_at, drop),
                Refusal(InvalidInput, "drop"),
            )
            for drop in (0.0, -1e-3, math.nan, math.inf)
        },
        {
            "a hand past the top": (
                partial(_above, [(TOP, TOP - 0.002), (TOP, TOP - 0.01), (TOP, TOP + 1e-3)], None),
                Refusal(IllConditioned, "not past the undeformed top"),
            ),
            "hands above a known top": (
                partial(_above, [(TOP, TOP + 1e-3), (TOP, TOP + 2e-3)], Estimate(TOP, 1e-5)),
                Refusal(IllConditioned, "do not tell"),
            ),
        },
        prefix="series, ",
    ),
    *group(
        "an object a thousand times softer or stiffer than the membrane, and powers at their bounds",
        {
            "a thousand times softer": (_soft, Range(0.0, 3.0)),
            "a thousand times stiffer": (
                lambda: fit(seen(spring(3e5), 2e-5)).stiffness(),
                Refusal(IllConditioned, "too little to tell; its stiffness is above"),
            ),
            "a thousand times stiffer, at a drop": (
                lambda: fit(seen(spring(3e5), 2e-5)).stiffness_at(DROP),
                Refusal(IllConditioned, "too little to tell"),
            ),
            "two readings": (
                lambda: fit(seen(spring(600.0), 5e-5, poses=[(0.0, 0.003), (0.0, 0.012)])),
                Range(0.02, 0.4, of=lambda found: found.drop.sd / found.drop.value),
            ),
            "a power below all": (partial(_at_bound, 0.3, FLATTEST), Value([FLATTEST, 0.0, 0.0], abs=1e-7)),
            "a power above all": (partial(_at_bound, 12.0, STEEPEST), Value([STEEPEST, 0.0, 0.0], abs=1e-7)),
        },
        {
            f"exact, {stiffness:g} N/m, power {power:g}": (
                partial(_exact, stiffness, power),
                Value([0.0] * 3, abs=2e-3),
            )
            for stiffness, power in ((80.0, 0.9), (600.0, 1.4), (4000.0, 2.2))
        },
        {
            f"a law of power {power:g}, stiffening {stiffening:g}": (
                partial(_deflected, 2e-3, power, stiffening),
                Value([0.0] * 3, abs=1e-9),
            )
            for power, stiffening in ((0.6, 0.0), (3.0, 0.4), (1.0, -0.02))
        },
        {
            "a rigid law": (
                lambda: ObjectLaw(0.0, 1.5, 0.1).deflection(np.log([0.5, 1.0]))[0],
                Value([0.0, 0.0]),
            ),
        },
        prefix="series, ",
    ),
    *group(
        "the error is the same in all readings, larger than stated, or hardly any",
        {
            "a model off by a factor": (_wrong_factor, Value([1.0, 0.8], abs=1e-6)),
            "scatter ten times as stated": (_scattered, Check("chi2 above 4, wide", lambda f: f[0] > 4 and f[1] > 0.4)),
            "a known top": (_known_top, Value(1.0, abs=1e-3)),
            "an error that all share": (
                _shared,
                Check("only force and stiffness", lambda f: f[0] > 2 and f[1] == 1 and f[2] > 1),
            ),
            "errors go against each other": (
                lambda: fit(seen(spring(300.0), 5e-5)).together,
                Range(-1.0, -1e-3),
            ),
        },
        {
            f"a hand off by {robot:g} m": (partial(_hardly_off, robot), Value([1.0, 1.0], abs=1e-6))
            for robot in (0.0, 1e-300, 1e-12, 1e-9)
        },
        {
            f"presses {presses}": (partial(_presses, poses), Value(presses))
            for poses, presses in (
                ([(0.0, 0.05)], [0]),
                ([(0.0, 0.05), (0.0, 0.05 + 0.9 * SAME), (0.0, 0.05)], [0, 0, 0]),
                ([(0.0, 0.05), (0.0, 0.05 + 1.1 * SAME), (0.0, 0.05)], [0, 1, 2]),
                ([(0.0, 0.05), (0.01, 0.05), (0.01, 0.05)], [0, 1, 1]),
                ([(0.0, 0.05 + 0.6 * SAME * i) for i in range(5)], [0, 0, 1, 1, 2]),
            )
        },
        prefix="series, ",
    ),
)
