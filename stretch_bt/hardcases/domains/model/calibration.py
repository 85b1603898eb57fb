"""Calibrations by presses that determine no model, or are wrong in part."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model.calibration.calibrate import calibrate
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.force.force_model import Range as Limits
from stretch_bt.model.force.membrane import MembraneHand, MembraneModel

NOTHING = tuple((0.0,) * 6 for _ in range(6))
SPAN = Limits((0.004, 0.06), (0.0, 0.08), (0.0, 0.025))
HAND = MembraneModel(MembraneHand(75e3, 0.0018, 0.0135, 0.15, 0.8, 0.10), NOTHING, 0.0, SPAN)
DIAMETERS, STRETCHES, DEPTHS = (0.01, 0.02, 0.03, 0.045, 0.06), (0.0, 0.02, 0.04, 0.06, 0.08), (1, 3, 5, 8, 11, 15)


def presses(
    diameters: Sequence[float] = DIAMETERS,
    stretches: Sequence[float] = STRETCHES,
    depths: Sequence[float] = DEPTHS,
    noise: float = 0.0,
) -> Measurements:
    """Return the forces of a hand, with noise."""
    d, x, z = (a.ravel() for a in np.meshgrid(diameters, stretches, np.array(depths) * 1e-3, indexing="ij"))
    exact = np.array([HAND.predict(*row)[0] for row in zip(d / 2, x, z, strict=True)])
    off = np.random.default_rng(0).normal(0, noise, len(d))
    return Measurements(d / 2, x, z, exact + off, np.full(len(d), max(noise, 1e-4)))


def _changed(given: Measurements, **arrays: Any) -> Measurements:
    """Return measurements with some arrays in the place of their own."""
    own = {n: getattr(given, n) for n in ("radius", "stretch", "depth", "force", "force_sd")}
    return Measurements(**(own | arrays))


def _flat(given: Measurements) -> Measurements:
    """Return the force of each stretch and depth under the first diameter, under all."""
    first = given.force[given.of_diameter(given.diameters[0])]
    return _changed(given, force=np.tile(first, len(given.diameters)) / np.sqrt(0.01 / given.radius / 2))


@cache
def _calibrated(noise: float = 0.0) -> Any:
    return calibrate(presses(noise=noise))


def _deep_error(given: Measurements) -> float:
    """Return the largest relative error of forces of a calibration, deeper than 3 mm, against the exact hand's."""
    clean = presses()
    model = calibrate(given).model
    return float(np.abs(forces(model, clean) / clean.force - 1)[clean.depth >= 3e-3].max())


def _outliers() -> Measurements:
    given = presses(noise=0.005)
    force = given.force.copy()
    force[::17] *= 3
    return _changed(given, force=force)


def _shifted() -> Measurements:
    given = presses(noise=0.005)
    return _changed(given, depth=np.maximum(given.depth - 2.5e-4, 0.0))


def _one_stretch() -> list[float]:
    """Return the deviation over the one from all stretches, and error over deviation, far from the one stretch that was measured."""
    place, few = (0.010, 0.07, 0.008), calibrate(presses(stretches=(0.02,), noise=0.01)).model
    force, sd = few.predict(*place)
    return [sd / _calibrated(0.01).model.predict(*place)[1], abs(force - HAND.predict(*place)[0]) / sd]


def _past(spoil: Callable[[Measurements], Measurements]) -> list[Any]:
    """Return the notes on the presses left out, and the largest relative error of the model."""
    found = calibrate(spoil(presses()))
    places = [(d / 2, x, z * 1e-3) for d in (0.02, 0.045) for x in (0.01, 0.05) for z in (5, 11)]
    off = [abs(found.model.predict(*p)[0] / HAND.predict(*p)[0] - 1) for p in places]
    return [*found.warnings, max(off)]


def _left_out(said: str) -> Check:
    return Check(f"left out: {said}", lambda found: found[:-1] == [f"left out: {said}"] and found[-1] < 0.01)


def _at_edge() -> int:
    given = presses()
    deep = (given.radius < 0.006) & (given.stretch > 0.07) & (given.depth > 0.014)
    return len(calibrate(_changed(given, depth=np.where(deep, 0.0152, given.depth))).residuals)


def _made(make: Callable[[], Measurements], model: str) -> Any:
    return calibrate(make(), model)


def _small() -> Any:
    given = presses(diameters=(0.02,))
    return calibrate(_changed(given, radius=np.full(len(given), 0.002)))


def _noise_of_paper() -> Measurements:
    given = presses()
    return _changed(given, force=3e-3 * given.force + np.random.default_rng(2).normal(0, 0.02, 150))


#: measurements, model and a pattern of the refusal
REFUSED: dict[str, tuple[Callable[[], Measurements], str, str]] = {
    "two presses": (lambda: presses((0.02,), (0.0,), (5, 10)), "membrane", "too few"),
    "a stuck sensor": (lambda: _changed(presses(), force=np.full(150, 0.3)), "membrane", "stuck"),
    "force that falls with depth": (lambda: _changed(presses(), force=5 - presses().force), "membrane", "grow"),
    "forces in mN": (lambda: _changed(presses(), force=1e3 * presses().force), "membrane", "unit"),
    "paper, one stretch": (lambda: presses(stretches=(0.02,)), "paper", "one stretch"),
    "paper, one diameter": (lambda: presses(diameters=(0.02,)), "paper", "there is 1;"),
    "paper, all noise": (_noise_of_paper, "paper", "times the forces that it says itself"),
    "paper, no decay": (lambda: _flat(presses()), "paper", "no decay"),
}

CASES: tuple[Hard, ...] = (
    *group(
        "presses that determine no model: too few, stuck, falling, in another unit, of one stretch or diameter, noise",
        {
            name: (partial(_made, made, model), Refusal(IllConditioned, said))
            for name, (made, model, said) in REFUSED.items()
        },
        {
            "forces NaN": (
                lambda: _changed(presses(), force=np.full(150, math.nan)),
                Refusal(InvalidInput, "finite"),
            ),
            "radii below 0": (
                lambda: _changed(presses(), radius=np.full(150, -0.01)),
                Refusal(InvalidInput, "radius"),
            ),
            "an unknown model": (lambda: calibrate(presses(), "spring"), Refusal(InvalidInput, "no model")),
            "nothing within the table": (_small, Refusal(IllConditioned, "diameter 4 mm, outside of 8 mm to 120 mm")),
        },
        prefix="calibration, ",
    ),
    *group(
        "outliers, a depth whose zero is off, presses past the table, and one stretch alone",
        {
            "exact": (lambda: _deep_error(presses()), Range(0.0, 0.005)),
            "as noisy as stated": (
                lambda: math.sqrt(_calibrated(0.01).model.covariance[0][0]),
                Value(4.67e3, rel=0.1),  # Pa, of the shear modulus, by the noise alone
            ),
            "outliers": (lambda: _deep_error(_outliers()), Range(0.0, 0.05)),
            "zero of depth off": (lambda: _deep_error(_shifted()), Range(0.0, 0.03)),
            "one stretch": (
                _one_stretch,
                Check("more uncertain, and within 3 deviations", lambda f: f[0] > 1.5 and f[1] < 3),
            ),
            "a small diameter": (
                partial(_past, lambda g: _changed(g, radius=np.where(g.of_diameter(0.01), 0.0025, g.radius))),
                _left_out("diameter 5 mm, outside of 8 mm to 120 mm"),
            ),
            "large depths": (
                partial(_past, lambda g: _changed(g, depth=np.where(g.depth > 0.014, 0.03, g.depth))),
                _left_out("25 presses at depths to 30 mm, past 25 mm"),
            ),
            "large stretches": (
                partial(_past, lambda g: _changed(g, stretch=np.where(g.stretch > 0.07, 0.12, g.stretch))),
                _left_out("30 presses at stretches to 120 mm, past 108 mm"),
            ),
            "at the edge of what the membrane bears": (_at_edge, Value(25)),
        },
        prefix="calibration, ",
        costly=("exact", "one stretch", "a small diameter", "large stretches"),
    ),
)
