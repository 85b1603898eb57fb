"""Force models out of their range and out of reach."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.hardcases.expect import Check, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import CalibratedHertz, ForceModel, MembraneModel, StretchState, next_indentation
from stretch_bt.model.force.force_model import Range
from stretch_bt.model.force.membrane import PARAMETERS, MembraneHand
from stretch_bt.model.force.membrane_table import SplineAxis, read_table

HERTZ = ForceModel.default()
LIMITS = Range((0.004, 0.06), (0.0, 0.08), (0.0, 0.025))
_SDS = np.array([2e3, 5e-5, 5e-4, 0.03, 0.1, 0.01])
COVARIANCE = tuple(map(tuple, np.diag(_SDS**2).tolist()))
MEMBRANE = MembraneModel(
    MembraneHand(68.4e3, 0.002, 0.0119, 0.1, 0.7, 0.08), COVARIANCE, 0.01, LIMITS, {"source": "a case"}
)
FLAT = StretchState(0.0, 5e3, 0.0, 0.0, 0.0, 0.02, 0.0)
NEVER_STIFFER = CalibratedHertz((FLAT, replace(FLAT, stretch=0.06)), 0.02, 0.0, HERTZ.range)
Ask = Callable[[Any], Any]
OUT: dict[str, tuple[Ask, Refusal]] = {
    "radius 70 mm": (
        lambda m: m.predict(0.070, 0.0, 0.01),
        Refusal(InvalidInput, "radius 70 mm .* 2.5 mm to 60 mm"),
    ),
    "stretch 100 mm": (lambda m: m.predict(0.010, 0.1, 0.01), Refusal(InvalidInput, "stretch 100 mm .* 0 mm to 80 mm")),
    "depth 40 mm": (lambda m: m.predict(0.010, 0.0, 0.04), Refusal(InvalidInput, "depth 40 mm .* 0 mm to 30 mm")),
    "radius NaN": (lambda m: m.predict(math.nan, 0.0, 0.01), Refusal(InvalidInput, "radius")),
    "radius 0": (lambda m: m.predict(0.0, 0.0, 0.01), Refusal(InvalidInput, "radius")),
    "radius below 0": (lambda m: m.predict(-0.01, 0.0, 0.01), Refusal(InvalidInput, "radius")),
    "an infinite radius": (lambda m: m.predict(math.inf, 0.0, 0.01), Refusal(InvalidInput, "radius")),
    "a force below 0": (lambda m: m.depth_for(0.010, 0.0, -1.0), Refusal(InvalidInput, "force")),
    "a force NaN": (lambda m: m.depth_for(0.010, 0.0, math.nan), Refusal(InvalidInput, "force")),
    "a depth for 50 N": (
        lambda m: m.depth_for(0.010, 0.0, 50.0),
        Refusal(NoEquilibrium, "past the calibrated 30 mm"),
    ),
    "a stretch for 50 N": (
        lambda m: m.stretch_for(0.010, 0.01, 50.0),
        Refusal(NoEquilibrium, "the calibrated stretches give"),
    ),
    "a stretch for 0 N": (lambda m: m.stretch_for(0.010, 0.01, 0.0), Refusal(NoEquilibrium, "no stretch gives 0 N")),
    "a stretch at no depth": (lambda m: m.stretch_for(0.010, 0.0, 1.0), Refusal(NoEquilibrium, "depth 0")),
}
#: radius, stretch and depth, m
OUTSIDE: dict[str, tuple[tuple[float, float, float], str]] = {
    "radius 0": ((0.0, 0.01, 0.01), "radius"),
    "radius below 0": ((-0.01, 0.01, 0.01), "radius"),
    "an infinite radius": ((math.inf, 0.01, 0.01), "radius"),
    "radius NaN": ((math.nan, 0.01, 0.01), "radius"),
    "stretch 200 mm": ((0.01, 0.2, 0.01), "stretch"),
    "stretch below 0": ((0.01, -0.01, 0.01), "stretch"),
    "depth 40 mm": ((0.01, 0.01, 0.04), "depth"),
    "depth below 0": ((0.01, 0.01, -1e-3), "depth"),
    "wrapped around": ((0.0041, 0.08, 0.025), "wrap"),
}


def _inverted(model: Any, radius: float, stretch: float, depth: float) -> list[float]:
    """Return the depth computed back from a force over the true one, the stretch less the true one, and force and depth of nothing."""
    force, sd = model.predict(radius, stretch, depth)
    assert 0 < sd < 0.5 * force
    told = model.depth_for(radius, stretch, force), model.stretch_for(radius, depth, force)
    return [
        told[0] / depth,
        told[1] - stretch,
        *model.predict(radius, stretch, 0.0),
        model.depth_for(radius, stretch, 0.0),
    ]


def _kept_force() -> float:
    """Return the force of the next indentation at another stretch over the force before."""
    force, _ = HERTZ.predict(0.02, 0.01, 0.008)
    return HERTZ.predict(0.02, 0.07, next_indentation(HERTZ, 0.02, 0.07, force))[0] / force


def _deviation_of(name: str) -> float:
    """Return the deviation of a force by one parameter alone over the change of the force by as much of it."""
    k, place = PARAMETERS.index(name), (0.012, 0.033, 0.007)
    step = 1e-3 * max(getattr(MEMBRANE.hand, name), 0.1 if k > 2 else 0)
    alone = np.zeros((6, 6))
    alone[k, k] = step**2
    rows = tuple(map(tuple, alone.tolist()))
    sd = MembraneModel(MEMBRANE.hand, rows, 0.0, LIMITS).predict(*place)[1]
    moved = MEMBRANE.hand._replace(**{name: getattr(MEMBRANE.hand, name) + step})
    return sd / abs(MembraneModel(moved, rows, 0.0, LIMITS).predict(*place)[0] - MEMBRANE.predict(*place)[0])


def _spread_of_draws() -> float:
    """Return the stated deviation of a modulus over the deviation of the moduli of drawn parameters."""
    assert isinstance(HERTZ, CalibratedHertz)
    random, drawn = np.random.default_rng(0), []
    for _ in range(400):
        states = tuple(
            replace(
                s, **{n: random.normal(getattr(s, n), getattr(s, f"{n}_sd")) for n in ("floor", "amplitude", "decay")}
            )
            for s in HERTZ.states
        )
        drawn.append(replace(HERTZ, states=states).modulus(0.02, 0.03)[0])
    return HERTZ.modulus(0.02, 0.03)[1] / float(np.std(drawn))


def _spline() -> float:
    """Return how far a spline is off a cubic, between its places, at both ends past them, and in its slopes."""
    places = np.array([0.0, 0.7, 1.0, 2.5, 3.0, 4.2])
    axis, cubic = SplineAxis(places), np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.3])
    inside = np.linspace(0.0, 4.2, 41)
    slope = cubic.deriv()
    off = [
        *(axis.many(inside) @ cubic(places) - cubic(inside)),
        axis.weights(5.2) @ cubic(places) - cubic(4.2) - slope(4.2),
        axis.weights(-1.0) @ cubic(places) - cubic(0.0) + slope(0.0),
        *(axis.slopes() @ cubic(places) - slope(places)),
    ]
    return float(np.abs(off).max())


def _rises() -> bool:
    """Whether the table and the logarithms made from it are finite and rise with depth and span."""
    table = read_table()
    both = (table.force, MEMBRANE.hand.logarithms(table.spans - 0.004, 0.2))
    return all(
        np.isfinite(v).all() and (np.diff(v, axis=2) > 0).all() and (np.diff(v[..., 1:], axis=1) > 0).all()
        for v in both
    )


def _hardly_pressed() -> list[float]:
    """Return forces at depths from 10 um down to 1 nm, N."""
    return [MEMBRANE.predict(0.01, 0.02, 10.0**-k)[0] for k in (5, 6, 7, 8, 9)]


def _one_power(forces: list[float]) -> bool:
    steps = -np.diff(np.log(forces))
    return bool(0 < forces[-1] < 1e-3 and (steps > 0.3).all() and np.ptp(steps) < 1e-6)


def _hangs() -> list[Any]:
    """Return the relative deviation of a sag, its part with surer parameters, and the cases without a sag."""
    told = MEMBRANE.hang(0.0)
    surer = replace(MEMBRANE, covariance=tuple(tuple(v / 100 for v in row) for row in COVARIANCE)).hang(0.0)
    slack = replace(MEMBRANE, hand=MEMBRANE.hand._replace(mount_prestretch=1e-3))
    assert told is not None
    assert surer is not None
    return [told.sd / told.value, surer.sd / told.sd, HERTZ.hang(0.0), slack.hang(0.0), slack.hang(0.01) is not None]


def _is_hang(found: list[Any]) -> bool:
    part, surer, of_hertz, slack, taut = found
    return 0.03 < part < 0.3 and surer < 1 and of_hertz is None and slack is None and taut


CASES: tuple[Hard, ...] = (
    *group(
        "a place out of the calibrated range, and a force that no depth or stretch within it gives",
        {name: (partial(ask, HERTZ), refusal) for name, (ask, refusal) in OUT.items()},
        {
            "a hand that does not stiffen": (
                lambda: NEVER_STIFFER.stretch_for(0.01, 0.01, 2 * NEVER_STIFFER.predict(0.01, 0.03, 0.01)[0]),
                Refusal(NoEquilibrium),
            ),
            "a hand without a deviation": (lambda: NEVER_STIFFER.predict(0.01, 0.03, 0.01)[1], Value(0.0)),
            "the same force at another stretch": (_kept_force, Value(1.0, abs=1e-9)),
            "deviation of drawn parameters": (_spread_of_draws, Value(1.0, abs=0.12)),
        },
        {
            f"there and back, radius {1e3 * r:g} mm, stretch {1e3 * x:g} mm, depth {1e3 * d:g} mm": (
                partial(_inverted, HERTZ, r, x, d),
                Value([1.0, 0.0, 0.0, 0.0, 0.0], abs=1e-9),
            )
            for r, x, d in ((0.0025, 0.0, 1e-4), (0.04, 0.08, 0.03), (0.02, 0.03, 0.01))
        },
        prefix="hertz model, ",
    ),
    *group(
        "a place out of the table, or so deep that the membrane wraps around",
        {
            name: (partial(MEMBRANE.predict, *place), Refusal(InvalidInput, said))
            for name, (place, said) in OUTSIDE.items()
        },
        {
            "a depth for 1 kN": (partial(MEMBRANE.depth_for, 0.01, 0.0, 1e3), Refusal(NoEquilibrium, "not reached")),
            "a stretch for 1 kN": (
                partial(MEMBRANE.stretch_for, 0.01, 0.01, 1e3),
                Refusal(NoEquilibrium, "no stretch gives"),
            ),
            "a force below 0": (partial(MEMBRANE.depth_for, 0.01, 0.0, -1.0), Refusal(InvalidInput, "force")),
            "a depth for 0 N": (partial(MEMBRANE.depth_for, 0.01, 0.0, 0.0), Value(0.0)),
            "hanging at 200 mm": (partial(MEMBRANE.hang, 0.2), Refusal(InvalidInput, "stretch")),
            "hanging": (_hangs, Check("stated to 3 to 30 %, and not for a slack or another hand", _is_hang)),
        },
        {
            f"there and back, radius {1e3 * r:g} mm, stretch {1e3 * x:g} mm, depth {1e3 * d:g} mm": (
                partial(_inverted, MEMBRANE, r, x, d),
                Value([1.0, 0.0, 0.0, 0.0, 0.0], abs=1e-9),
            )
            for r, x, d in ((0.005, 0.0, 2e-3), (0.045, 0.08, 0.015), (0.02, 0.03, 0.01))
        },
        {f"deviation by {name}": (partial(_deviation_of, name), Value(1.0, abs=0.03)) for name in PARAMETERS},
        {
            "hardly any depth": (
                _hardly_pressed,
                Check("less and less force, by one power of the depth", _one_power),
            ),
            "its table": (_rises, Value(True)),
            "its splines": (_spline, Value(0.0, abs=1e-12)),
        },
        prefix="membrane model, ",
    ),
)
