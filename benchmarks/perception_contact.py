"""Size of round contacts from one frame: accuracy beside its bound and its cost.

`python benchmarks/perception_contact.py [FRAMES]`, 1000 by default, seeds 0, 1, ... Cylinders of 10 to 30 mm press into the
sheet of the solver, off its centre, at places, stretches and depths that the skirt's prior has not seen, and the prior
leaves out the diameter that is measured. A miss is an error over 5 mm or a refusal. The bound is the Cramer-Rao bound
(van Trees, with the prior) for the model at the solution without noise; under correlated noise the bound of least squares.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
import numpy.typing as npt
from perception_skirt import fine_cells, prior_from, table
from perception_skirt import presses as training_presses

from stretch_bt.accuracy.perception.noise import CORRELATED, WHITE_05, Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.accuracy.summary import rms
from stretch_bt.errors import NoAnswer
from stretch_bt.perception import find_contact, measure_contact
from stretch_bt.perception.size.choose import best_fit
from stretch_bt.perception.size.hypothesis import Context, hypothesis
from stretch_bt.perception.size.prior import SkirtPrior
from stretch_bt.perception.size.start import start_of
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

Array = npt.NDArray[np.float64]
MM = 1e3

DIAMETERS, STRETCHES, DEPTHS = (10, 15, 20, 25, 30), (0, 8, 25, 45, 60), (5, 8, 11, 15)
CELL_SD = {WHITE_05: 0.5e-3 / 3, CORRELATED: 0.62e-3 * np.sqrt(4 * np.pi) * CORRELATED.kernel / 3}


@dataclass(frozen=True)
class Setting:
    """What is measured: noise, hypothesis, least depth, m, and whether the stretch is known."""

    title: str
    noise: Noise
    shape: str
    least: float = 0.0
    stretch_known: bool = True


SETTINGS = (
    Setting("white 0.5 mm, one frame, shape chosen (asked: rms 0.4 mm, no miss)", WHITE_05, "auto"),
    Setting("white 0.5 mm, one frame, ellipse forced (asked: rms along i 0.5 mm, along j stated)", WHITE_05, "ellipse"),
    Setting("white 0.5 mm, one frame, shape chosen, stretch not known", WHITE_05, "auto", 0.0, False),
    Setting(
        "correlated 1 mm, 8 frames, depth 10 mm and more, shape chosen (asked: rms 1 mm, misses under 1 %)",
        CORRELATED,
        "auto",
        10e-3,
    ),
)


def tested() -> list[BodyPress]:
    """Return 100 presses in an order that mixes them."""
    rng = np.random.default_rng(7)
    cases = list(product(DIAMETERS, STRETCHES, DEPTHS))
    places = np.round(rng.uniform(-8, 8, (len(cases), 2)), 2)
    found = [
        BodyPress(Cylinder(d * 1e-3), x * 1e-3, z * 1e-3, (float(u) * 1e-3, float(v) * 1e-3))
        for (d, x, z), (u, v) in zip(cases, places, strict=True)
    ]
    return [found[n] for n in rng.permutation(len(found))]


@lru_cache(maxsize=1)
def rows() -> Array:
    return table(training_presses())


@lru_cache(maxsize=8)
def prior_without(diameter: float) -> SkirtPrior:
    kept = rows()[:, 0] != diameter
    return prior_from(rows()[kept])


@lru_cache(maxsize=512)
def bound(press: BodyPress, shape_name: str, cell_sd: float, stretch_known: bool) -> tuple[float, float]:
    """Return the bounds, m, of the diameters along i and along j."""
    prior = prior_without(diameter_of(press))
    shape = hypothesis(shape_name, Context(press.stretch if stretch_known else None, 1e-3, 0.0, prior))
    cells = fine_cells(seen(press))
    fit = best_fit(shape, cells, start_of(cells))
    _, jacobian = shape.model(fit.q, cells.x[fit.window], cells.y[fit.window])
    _, by_prior = shape.prior(fit.q)
    information = jacobian @ jacobian.T / cell_sd**2 + by_prior @ by_prior.T
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    size = shape.measure(fit.q, covariance)
    return size.diameter_i[1], size.diameter_j[1]


def diameter_of(press: BodyPress) -> float:
    assert isinstance(press.indenter, Cylinder)
    return press.indenter.diameter


def run(setting: Setting, frames: int) -> Iterator[str]:
    presses = [p for p in tested() if p.depth >= setting.least]
    results, times, shapes = [], [], Counter[str]()
    for seed in range(frames):
        press = presses[seed % len(presses)]
        frame = observe(seen(press), setting.noise, seed)
        stretch = press.stretch if setting.stretch_known else None
        diameter = diameter_of(press)
        try:
            contact = find_contact(frame)
            began = time.process_time()
            size = measure_contact(
                contact.surface,
                contact.labels,
                stretch=stretch,
                hypothesis=setting.shape,
                fillet_sd=0.0,
                prior=prior_without(diameter),
            )
        except NoAnswer as refused:
            shapes["refused"] += 1
            results.append((diameter, press.stretch, press.depth, *[np.nan] * 6))
            print(
                f"   refused: D {diameter * MM:g}, stretch {press.stretch * MM:g}, depth {press.depth * MM:g}: {refused}"
            )
            continue
        times.append(MM * (time.process_time() - began))
        shapes[size.shape] += 1
        limits = bound(
            press,
            size.shape if size.shape in ("circle", "ellipse") else "circle",
            CELL_SD[setting.noise],
            setting.stretch_known,
        )
        errors = size.diameter_i - diameter, size.diameter_i_sd, size.diameter_j - diameter, size.diameter_j_sd
        results.append((diameter, press.stretch, press.depth, *errors, *limits))
    yield from report(setting, np.array(results), times, shapes)


def report(setting: Setting, results: Array, times: list[float], shapes: Counter[str]) -> Iterator[str]:
    yield f"== {setting.title}; {len(results)} frames"
    yield f"   chosen: {dict(shapes)}; {np.median(times):.1f} ms CPU"
    yield "   of                rms i mm (bias)  rms j mm   bound i, j   misses   error over stated sd i, j"
    yield line("all", results)
    for column, name in ((1, "stretch"), (2, "depth"), (0, "diameter")):
        for value in np.unique(results[:, column]):
            yield line(f"{name} {value * MM:g} mm", results[results[:, column] == value])


def line(name: str, part: Array) -> str:
    found = part[np.isfinite(part[:, 3])]
    i, i_sd, j, j_sd, bound_i, bound_j = found[:, 3:].T
    misses = len(part) - len(found) + int((np.maximum(np.abs(i), np.abs(j)) > 5e-3).sum())
    return (
        f"   {name:16s}  {MM * rms(i):8.3f} ({MM * i.mean():+.3f})  {MM * rms(j):8.3f}  {MM * rms(bound_i):6.3f} {MM * rms(bound_j):6.3f}"
        f"  {misses:3d} of {len(part):4d}  {rms(i / i_sd):5.2f} {rms(j / j_sd):5.2f}"
    )


def main() -> None:
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    for setting in SETTINGS:
        for text in run(setting, frames):
            print(text, flush=True)


if __name__ == "__main__":
    main()
