"""Make the prior of the skirt around rectangles from presses of the sheet solver.

python benchmarks/perception_skirt_rectangle.py [FILE] [PRESSES]

Boxes of 8 to 32 mm, at any angle, are pressed into the hand's sheet off its centre, at stretches of 0 to 60 mm and depths of
2 to 16 mm, and the skirt is fitted without noise around the true sides. Prints the residuals of the regression, and the errors
of fits without noise that are given the prior of the other half of the presses.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from perception_skirt import fine_cells

from stretch_bt.accuracy.perception.view import BodyPress, seen
from stretch_bt.errors import NoAnswer, NoEquilibrium
from stretch_bt.perception.size import box_prior
from stretch_bt.perception.size.around import ORDERS
from stretch_bt.perception.size.box_prior import (
    TARGETS,
    BoxPrior,
    BoxRegression,
    box_terms,
    looseness,
    matching,
    steady_terms,
)
from stretch_bt.perception.size.cells import HeightCells
from stretch_bt.perception.size.choose import best_fit
from stretch_bt.perception.size.fit import fit_to
from stretch_bt.perception.size.free_form import FreeForm
from stretch_bt.perception.size.hypothesis import Context, FittedSizes
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.rectangle import GEOMETRY, HEIGHT, RATIO, SKIRT, Rectangle
from stretch_bt.perception.size.start import start_of
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

Array = npt.NDArray[np.float64]

FILE = Path(box_prior.__file__).with_name("box_skirt.json")
COUNT = 700
LOW = np.array([8e-3, 8e-3, -np.pi / 2, -4e-3, 2e-3, -9e-3, -9e-3])  # sides, angle, stretch (from 0), depth, place
HIGH = np.array([32e-3, 32e-3, np.pi / 2, 60e-3, 16e-3, 9e-3, 9e-3])
RIDGE = 1e-5
OUTLIER = 6.0


def presses(count: int) -> list[BodyPress]:
    """Return presses spread by a Sobol sequence."""
    from scipy.stats import qmc

    cases = LOW + (HIGH - LOW) * qmc.Sobol(7, scramble=True, seed=7).random(1024)[:count]
    cases[:, 3] = np.maximum(cases[:, 3], 0.0)
    return [BodyPress(Box(*c[:3].tolist()), float(c[3]), float(c[4]), (float(c[5]), float(c[6]))) for c in cases]


def weak_prior() -> BoxPrior:
    """Return a prior that only keeps a fit without noise from running away."""
    spread = np.array([0.5, *((0.5 if kind == "square" else 3.0 if n <= 2 else 0.1) for kind, n, _ in ORDERS)])
    coefficients = np.zeros((box_terms(np.ones((1, 6)), 0.0)[0].shape[1], TARGETS))
    coefficients[0, :2], coefficients[1, 0] = (2.3, 0.4), -0.7
    one = BoxRegression(coefficients, np.diag(spread**2), np.zeros(TARGETS), np.zeros((6, 2)))
    return BoxPrior(one, one, np.zeros(5), np.zeros(2))


class Held(Rectangle):
    """A rectangle whose centre, sides and rotation are held at given ones."""

    def __init__(self, context: Context, prior: BoxPrior, at: Array) -> None:
        super().__init__(context, prior)
        self.at = at

    def prior(self, q: Array) -> tuple[Array, Array]:
        """Return what the prior holds against q, with the shape's deviation, and its Jacobian."""
        against, by = super().prior(q)
        held = np.zeros((q.size, 5))
        held[:5] = np.eye(5) * 1e8
        return np.concatenate([against, (q[:5] - self.at) * 1e8]), np.hstack([by, held])


def truth_of(press: BodyPress) -> Array:
    """Return x, y, sides, rotation and depth of a press."""
    assert isinstance(press.indenter, Box)
    return np.array([*press.at, press.indenter.first, press.indenter.second, press.indenter.angle, press.depth])


def start_at(press: BodyPress) -> Array:
    """Return parameters at the truth with about the right skirt."""
    truth, q = truth_of(press), np.zeros(9 + len(ORDERS))
    q[:5], q[HEIGHT], q[RATIO], q[SKIRT.start] = truth[:5], truth[5], 2.0, 0.4 * truth[5]
    return q


def context_of(press: BodyPress) -> Context:
    assert isinstance(press.indenter, Box)
    return Context(press.stretch, press.indenter.edge, 0.0, shipped_prior())


def row_of(press: BodyPress) -> Array | None:
    """Return the six sizes, the stretch and the targets; None where the sheet has no equilibrium."""
    try:
        cells = fine_cells(seen(press))
    except NoEquilibrium:
        return None
    shape = Held(context_of(press), weak_prior(), truth_of(press)[:5])
    q = fit_to(shape, cells, start_at(press)).q
    return np.concatenate([truth_of(press)[:5], [q[HEIGHT], press.stretch, q[RATIO]], q[SKIRT] / q[HEIGHT]])


def regress(rows: Array, *, known: bool) -> BoxRegression:
    """Return the regression of the targets, each on the terms of its mirror class, and the covariance of what it leaves."""
    terms, classes = box_terms(rows[:, :6], rows[:, 6] if known else None)
    coefficients, left = np.zeros((terms.shape[1], TARGETS)), np.zeros((len(rows), TARGETS))
    for target, kind in enumerate(matching()):
        chosen = terms[:, classes == kind]
        normal = chosen.T @ chosen + RIDGE * len(rows) * np.eye(chosen.shape[1])
        solution = np.linalg.solve(normal, chosen.T @ rows[:, 7 + target])
        coefficients[classes == kind, target] = solution
        hat = np.einsum("ij,ij->i", chosen, np.linalg.solve(normal, chosen.T).T)
        left[:, target] = (rows[:, 7 + target] - chosen @ solution) / (1.0 - hat)
    slack = np.zeros(TARGETS)
    if known:
        loose = np.log(looseness(rows[:, 6]))
        design = np.column_stack([np.ones(len(rows)), loose])
        slack = np.linalg.lstsq(design, np.log(np.abs(left) + 1e-6), rcond=None)[0][1]
        left = left / np.exp(loose[:, None] * slack)
    return BoxRegression(coefficients, _covariance(left), slack, np.zeros((6 if known else 3, 2)))


def _covariance(left: Array) -> Array:
    """Return the covariance of residuals, with the residuals of outlying rows scaled down."""
    scale = 1.4826 * np.median(np.abs(left), axis=0)
    size = np.sqrt(((left / scale) ** 2).mean(axis=1))
    kept = left * np.minimum(1.0, OUTLIER / np.maximum(size, 1e-9))[:, None]
    return np.asarray(kept.T @ kept / len(left))


def prior_from(rows: Array) -> BoxPrior:
    """Return the prior that rows of presses give, with nothing that fits miss."""
    return BoxPrior(regress(rows, known=True), regress(rows, known=False), np.zeros(5), np.zeros(2))


def missed(press: BodyPress, prior: BoxPrior) -> Array:
    """Return what a fit without noise misses: x, y, sides, m, rotation, rad."""
    truth = truth_of(press)
    shape = Rectangle(context_of(press), prior)
    q = start_at(press)
    q[RATIO], q[SKIRT] = 0.0, 0.0
    mean = prior.mean(q[GEOMETRY][None], press.stretch)[0]
    q[RATIO], q[SKIRT] = mean[0], mean[1:] * press.depth
    return fit_to(shape, fine_cells(seen(press)), q).q[:5] - truth[:5]


def halves_miss(wanted: list[BodyPress], rows: Array) -> tuple[Array, Array]:
    """Return (n, 5) what fits miss with the prior of the other half of the presses, and the presses' numbers."""
    found, numbers = [], []
    for half in (0, 1):
        prior = prior_from(rows[1 - half :: 2])
        for number in range(half, len(wanted), 2):
            try:
                found.append(missed(wanted[number], prior))
                numbers.append(number)
            except NoAnswer as error:
                print(f"no fit of {wanted[number]}: {error}")
    return np.array(found), np.array(numbers)


def steady_of(rows: Array, errors: Array, *, known: bool) -> Array:
    """Return the regression (terms, 2) of what sides along i and j are to be corrected by, robust to rare wrong fits."""
    terms = steady_terms(rows[:, 5], rows[:, 6] if known else None)
    share = np.cos(rows[:, 4]) ** 2
    design = np.vstack(
        [np.hstack([terms * part[:, None] for part in parts]) for parts in ((share, 1 - share), (1 - share, share))]
    )
    wanted = -np.concatenate([errors[:, 2], errors[:, 3]])
    near = np.abs(wanted) < OUTLIER * 1.4826 * np.median(np.abs(wanted))
    return np.asarray(np.linalg.lstsq(design[near], wanted[near], rcond=None)[0].reshape(2, -1).T)


def corrected(rows: Array, errors: Array, steady: Array) -> Array:
    """Return errors, with the errors of the sides corrected."""
    by = steady_terms(rows[:, 5], rows[:, 6]) @ steady
    share = np.cos(rows[:, 4]) ** 2
    found = errors.copy()
    found[:, 2] += share * by[:, 0] + (1 - share) * by[:, 1]
    found[:, 3] += (1 - share) * by[:, 0] + share * by[:, 1]
    return found


def systematic_of(errors: Array, rotation: Array) -> Array:
    """Return rms (5,): x, y, a side along i and one along j, m, rotation, rad; robust to rare wrong fits."""
    errors = np.where(np.abs(errors) > 5.0 * np.median(np.abs(errors), axis=0) * 1.4826, np.nan, errors)
    share = np.cos(rotation) ** 2
    squares = np.concatenate([errors[:, 2] ** 2, errors[:, 3] ** 2])
    design = np.column_stack([np.concatenate([share, 1 - share]), np.concatenate([1 - share, share])])
    seen_ = np.isfinite(squares)
    sides = np.linalg.lstsq(design[seen_], squares[seen_], rcond=None)[0]
    x, y, turn = (math.sqrt(float(np.nanmean(errors[:, n] ** 2))) for n in (0, 1, 4))
    return np.array([x, y, *np.sqrt(np.maximum(sides, 1e-10)), turn])


def free_form_misses(prior: BoxPrior, wanted: list[BodyPress]) -> Array:
    """Return (n, 2) what free outlines without noise miss of the widths of cylinders and boxes through their centre, m."""
    found = []
    for press in wanted:
        shape = FreeForm(Context(press.stretch, 1e-3, 0.0, shipped_prior()), prior)
        cells = fine_cells(seen(press))
        try:
            size = choose_start(shape, cells)
        except NoAnswer:
            continue
        found.append([size.diameter_i[0] - width_of(press, 0.0), size.diameter_j[0] - width_of(press, math.pi / 2)])
    return np.array(found)


def choose_start(shape: FreeForm, cells: HeightCells) -> FittedSizes:
    """Return what a free outline measures."""
    fit = best_fit(shape, cells, start_of(cells))
    return shape.measure(fit.q, fit.covariance)


def width_of(press: BodyPress, direction: float) -> float:
    """Return the width through the centre of the object that is pressed in, m."""
    body = press.indenter
    if isinstance(body, Cylinder):
        return body.diameter
    assert isinstance(body, Box)
    c, s = abs(math.cos(direction - body.angle)), abs(math.sin(direction - body.angle))
    return min(body.first / max(c, 1e-9), body.second / max(s, 1e-9))


def round_presses() -> list[BodyPress]:
    """Return every seventh of the cylinders that the round prior is made from, at a depth of 5 mm and more."""
    from perception_skirt import presses as cylinders

    return [p for p in cylinders()[::7] if p.depth >= 5e-3]


def main() -> None:
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else FILE
    wanted = presses(int(sys.argv[2]) if len(sys.argv) > 2 else COUNT)
    solved = [(press, row) for press, row in ((p, row_of(p)) for p in wanted) if row is not None]
    kept, rows = [p for p, _ in solved], np.array([r for _, r in solved])
    whole = regress(rows, known=True)
    print(f"{len(rows)} presses of {len(wanted)}; sd of what the regression leaves, each press left out")
    print("  ln ratio  coefficients over the depth")
    sd = np.sqrt(np.diag(whole.covariance))
    print(f"  {sd[0]:8.3f}  {' '.join(f'{s:.3f}' for s in sd[1:])}")
    errors, numbers = halves_miss(kept, rows)
    fitted = rows[numbers]
    steady = [steady_of(fitted, errors, known=known) for known in (True, False)]
    systematic = systematic_of(corrected(fitted, errors, steady[0]), fitted[:, 4])
    units = [(1e3, "mm")] * 4 + [(180.0 / math.pi, "degrees")]
    names = ("x", "y", "side along i", "side along j", "rotation")
    print("missed without noise with the prior of the other half of the presses, the steady part taken off, rms:")
    for name, value, (scale, unit) in zip(names, systematic, units, strict=True):
        print(f"  {name:14s} {value * scale:.2f} {unit}")
    made = prior_from(rows)
    known, unknown = (replace(part, steady=s) for part, s in zip((made.known, made.unknown), steady, strict=True))
    misses = free_form_misses(made, round_presses() + [p for p in kept[::5] if p.depth >= 5e-3])
    free_form = np.sqrt(np.mean(misses**2, axis=0))
    print(f"free outlines miss along i {free_form[0] * 1e3:.2f}, along j {free_form[1] * 1e3:.2f} mm rms")
    made = BoxPrior(known, unknown, systematic, free_form)
    file.write_text(made.to_json() + "\n", encoding="utf-8")
    print(f"written to {file}")


if __name__ == "__main__":
    main()
