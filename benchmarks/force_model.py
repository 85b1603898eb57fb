"""Force models on hands they do not know: error on a diameter left out, by depth and stretch, and the cost of a prediction.

    python -m benchmarks.force_hands FOLDER
    python -m benchmarks.force_model FOLDER [--sheet]

The models see what the protocol measures with noise; errors are against the forces without it. `--sheet` also solves the sheet
at each state of one hand.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.force.hands import DEPTHS, DIAMETERS, STRETCHES, measured
from stretch_bt.model.calibration.calibrate import Fit, widened
from stretch_bt.model.calibration.calibrate_hertz import fit_calibrated_hertz
from stretch_bt.model.calibration.calibrate_membrane import ROBOT_SD, fit_membrane
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.force.force_model import ForceModel

Array = npt.NDArray[np.float64]

MODELS: dict[str, Fit] = {"paper": fit_calibrated_hertz, "membrane": fit_membrane}
SHOWN = (0, 1, 2, 4, 7, 9, 14)
NEXT, HEIGHT = 100, 1e-4  # runs, and the standard deviation of a height, m


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sheet", action="store_true")
    given = parser.parse_args()
    hands = [(int(p.stem[-3:]), np.load(p)["force"]) for p in sorted(given.folder.glob("hand_*.npz"))]
    print(
        f"{len(hands)} hands, mean force {np.mean([f.mean() for _, f in hands]):.2f} N, largest {max(f.max() for _, f in hands):.1f} N"
    )
    for name, fit in MODELS.items():
        _show(name, np.array([_left_out(fit, true, seed) for seed, true in hands]), np.array([t for _, t in hands]))
    _show_stated(hands)
    _show_next(hands)
    _show_cost(measured(hands[0][1], hands[0][0]), sheet=given.sheet)


def _left_out(fit: Fit, true: Array, seed: int) -> Array:
    """Return (diameters, stretches, depths) float, N: what models that have not seen each diameter say."""
    seen = measured(true, seed)
    exact = Measurements(seen.radius, seen.stretch, seen.depth, true.ravel(), seen.force_sd)
    told = np.zeros(true.size)
    for diameter in seen.diameters:
        mask = seen.of_diameter(diameter)
        told[mask] = forces(widened(fit(seen.where(~mask), None), seen), exact.where(mask))
    return told.reshape(true.shape)


def _show(name: str, told: Array, true: Array) -> None:
    off, relative = told - true, told / true - 1
    inner = slice(1, -1)
    deep = np.broadcast_to((STRETCHES >= 0.01)[:, None] & (DEPTHS >= 0.005), told.shape)
    print(
        f"\n{name}, one diameter left out: mean absolute error {np.abs(off).mean():.4f} N, inner diameters {np.abs(off[:, inner]).mean():.4f} N"
    )
    per_hand = np.abs(off).mean(axis=(1, 2, 3))
    print(
        f"  by hand {per_hand.min():.4f} to {per_hand.max():.4f} N; rms relative, depth 5 mm and stretch 10 mm and more: {_rms(relative[deep]):.2f} %"
    )
    print("  depth, mm          " + "".join(f"{1e3 * DEPTHS[k]:9.0f}" for k in SHOWN))
    print("  rms relative, %    " + "".join(f"{_rms(relative[..., k]):9.2f}" for k in SHOWN))
    print("  mean relative, %   " + "".join(f"{100 * relative[..., k].mean():9.2f}" for k in SHOWN))
    print("  stretch, mm        " + "".join(f"{1e3 * x:9.0f}" for x in STRETCHES))
    print("  rms relative, %    " + "".join(f"{_rms(relative[:, :, j]):9.2f}" for j in range(len(STRETCHES))))
    print("  diameter, mm       " + "".join(f"{1e3 * d:9.0f}" for d in DIAMETERS))
    print("  mean absolute, N   " + "".join(f"{np.abs(off[:, i]).mean():9.4f}" for i in range(len(DIAMETERS))))


def _show_stated(hands: list[tuple[int, Array]]) -> None:
    """Print the error of models fitted to all diameters over the standard deviation that they state."""
    ratios = []
    for seed, true in hands:
        seen = measured(true, seed)
        model = fit_membrane(seen, None)
        told = np.array([model.predict(*row) for row in zip(seen.radius, seen.stretch, seen.depth, strict=True)])
        deep = seen.depth >= 2e-3
        ratios.append(((told[:, 0] - true.ravel()) / told[:, 1])[deep])
    print(
        f"\nmembrane, all diameters: error over stated deviation, depth 2 mm and more: rms {_rms(np.concatenate(ratios)) / 100:.2f}"
    )


def _show_next(hands: list[tuple[int, Array]]) -> None:
    """Print how often the true force falls by over 2 % and 10 mN from a press to the next, at the next indentation of another stretch."""
    falls, runs = {0.0: 0, 3.0: 0}, 0
    for seed, true in hands:
        random, model = np.random.default_rng([seed, 63]), fit_membrane(measured(true, seed), None)
        for _ in range(math.ceil(NEXT / len(hands))):
            runs += 1
            walk = _Walk(random, model, true)
            for margin in falls:
                falls[margin] += walk.falls(margin)
    told = ", ".join(f"{n} of {runs} with {m:.0f} standard deviations to spare" for m, n in falls.items())
    print(f"force that falls on the way through five stretches, at the next indentation: {told}")


class _Walk:
    """A hand that goes from stretch to stretch over a sphere, with errors of its height, of the arm and of the radius."""

    def __init__(self, random: np.random.Generator, model: ForceModel, true: Array) -> None:
        self.model, self.index = model, int(random.integers(1, len(DIAMETERS)))
        self.radius = float(DIAMETERS[self.index]) / 2
        self.told = self.radius * float(random.normal(1, 0.02))
        self.first = float(random.uniform(0.006, 0.011))
        self.height, self.robot = float(random.normal(0, HEIGHT)), random.normal(0, ROBOT_SD, 8)
        self.true = np.log(true[self.index])

    def falls(self, margin: float) -> bool:
        """Return whether the true force falls anywhere."""
        depth, forces = self.first, []
        for k in range(1, 6):
            stretch = float(STRETCHES[k])
            forces.append(self._true(k, depth + self.height + self.robot[k]))
            if k < 5:
                force, onward = self.model.predict(self.told, stretch, depth)[0], float(STRETCHES[k + 1])
                depth = self.model.depth_for(
                    self.told, onward, force + margin * self._off(stretch, onward, depth, force)
                )
        return any(b < 0.98 * a and a - b > 0.01 for a, b in pairwise(forces))

    def _off(self, stretch: float, onward: float, depth: float, force: float) -> float:
        """Return the standard deviation of the next force beside this one, as `plan_press` has it."""
        there = self._slope(onward, self.model.depth_for(self.told, onward, force))
        return math.hypot((self._slope(stretch, depth) - there) * HEIGHT, math.sqrt(2) * ROBOT_SD * there, 0.01 * force)

    def _slope(self, stretch: float, depth: float) -> float:
        return (
            self.model.predict(self.told, stretch, depth)[0] - self.model.predict(self.told, stretch, depth - 1e-5)[0]
        ) / 1e-5

    def _true(self, k: int, depth: float) -> float:
        return float(np.exp(np.interp(math.log(depth), np.log(DEPTHS), self.true[k])))


def _show_cost(seen: Measurements, *, sheet: bool) -> None:
    print("\n                 predict, us   the same place   depth_for, us   stretch_for, us   inverse off by")
    models = {name: fit(seen, None) for name, fit in MODELS.items()}
    if sheet:
        from stretch_bt.simulation.sheet_model import SheetModel

        known = models["membrane"]
        models["sheet"] = SheetModel.from_json(known.to_json())
        _show_sheet(models["sheet"], known)
    for name, model in models.items():
        _show_calls(name, model, 20 if name == "sheet" else 2000)


def _show_calls(name: str, model: ForceModel, count: int) -> None:
    places = [(0.009 + 1e-5 * k % 0.012, 0.02 + 1e-5 * k % 0.03, 0.004 + 1e-6 * k) for k in range(count)]
    wanted = [(r, x, d, model.predict(r, x, d)[0]) for r, x, d in places]
    columns = [
        _cost(lambda p: model.predict(*p), places),
        _cost(lambda p: model.predict(0.015, 0.02, p[2]), places),
        _cost(lambda p: model.depth_for(p[0], p[1], p[3]), wanted),
        _cost(lambda p: model.stretch_for(p[0], p[2], p[3]), wanted),
    ]
    off = max(abs(model.depth_for(r, x, f) / d - 1) for r, x, d, f in wanted)
    print(f"{name:14} " + "".join(f"{c:13.0f}  " for c in columns) + f"   {off:.1e}")


def _show_sheet(model: ForceModel, table: ForceModel) -> None:
    places = [
        (r, x, d) for r in (0.0075, 0.0125, 0.025) for x in (0.005, 0.035, 0.07) for d in (0.0025, 0.0065, 0.0125)
    ]
    ratios = np.array([model.predict(*p)[0] / table.predict(*p)[0] - 1 for p in places])
    print(
        f"the sheet, solved, over the table between its places: rms {_rms(ratios):.2f} %, largest {100 * np.abs(ratios).max():.2f} %"
    )


def _cost(call: Callable[[tuple[float, ...]], object], places: Sequence[tuple[float, ...]]) -> float:
    """Return the median CPU time of a call, us."""
    times = []
    for place in places:
        began = time.process_time_ns()
        call(place)
        times.append(time.process_time_ns() - began)
    return float(np.median(times)) / 1e3


def _rms(values: Array) -> float:
    return 100 * float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main()
