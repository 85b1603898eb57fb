"""Make the prior of a membrane's skirt from presses of the sheet solver: python benchmarks/perception_skirt.py [FILE]

Cylinders of 8 to 34 mm are pressed into the hand's sheet, off its centre, at stretches of 0 to 60 mm, and fitted without
noise and with hardly a prior. Prints the residuals of the regression on stretch, depth and size when each diameter is left out.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.perception.noise import Noise, observe
from stretch_bt.accuracy.perception.view import BodyPress, SheetView, seen
from stretch_bt.errors import NoAnswer
from stretch_bt.perception import deproject, to_membrane
from stretch_bt.perception.size import prior as prior_module
from stretch_bt.perception.size.cells import HeightCells, cells_of
from stretch_bt.perception.size.circle import Circle
from stretch_bt.perception.size.conformal import COUNT
from stretch_bt.perception.size.fit import fit_to
from stretch_bt.perception.size.hypothesis import Context
from stretch_bt.perception.size.prior import Regression, SkirtPrior, features, powers
from stretch_bt.perception.size.start import start_of
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder

Array = npt.NDArray[np.float64]

DIAMETERS = (8, 10, 12.5, 15, 17.5, 20, 22.5, 25, 27.5, 30, 34)
STRETCHES = (0, 2, 5, 10, 15, 20, 30, 40, 50, 60)
DEPTHS = (2, 3.5, 5, 7.5, 10, 12.5, 15)
OFF_CENTRE = 16  # mm, the range of places across and along
FINE = Noise(quantum=4e-6, dropouts=0.0)
DEGREE = 3
FILE = Path(prior_module.__file__).with_name("skirt.json")


def presses() -> list[BodyPress]:
    """Return the presses, off centre by a Halton sequence."""
    from scipy.stats import qmc

    cases = list(product(DIAMETERS, STRETCHES, DEPTHS))
    places = np.round(OFF_CENTRE * qmc.Halton(2, scramble=False).random(len(cases) + 1)[1:] - OFF_CENTRE / 2, 2)
    return [
        BodyPress(Cylinder(d * 1e-3), x * 1e-3, z * 1e-3, (float(u) * 1e-3, float(v) * 1e-3))
        for (d, x, z), (u, v) in zip(cases, places, strict=True)
    ]


def fine_cells(view: SheetView) -> HeightCells:
    """Return the cells of a press without noise, labelled by the truth."""
    frame = observe(view, FINE, 0)
    points, valid = deproject(frame)
    points = to_membrane(points, 0.2)
    face = view.touching | (points[..., 2] > view.press.depth - 0.1e-3)
    return cells_of(points, np.where(valid, np.where(face, 2, 1), 255).astype(np.uint8))


def weak_prior() -> SkirtPrior:
    """Return a prior that only keeps a fit without noise from running away."""
    mean = np.array([2.0, 0.4, *np.zeros(COUNT - 1), 0.0])
    spread = np.array([2.0, *np.full(COUNT, 3.0), 1e-3])
    nothing = np.zeros(0)
    one = Regression((), nothing, nothing, nothing, nothing, np.zeros((1, 0), np.int64), mean[None], np.diag(spread**2))
    return SkirtPrior(one, one)


def row_of(press: BodyPress) -> list[float] | None:
    """Return diameter, stretch, depth, radius as fitted, and the nine targets of the prior; None where none is found."""
    return row_of_view(seen(press), press)


def row_of_view(view: SheetView, press: BodyPress) -> list[float] | None:
    """Return the row of a press that was solved."""
    assert isinstance(press.indenter, Cylinder)
    cells = fine_cells(view)
    shape = Circle(Context(press.stretch, press.indenter.rim, 0.0, weak_prior()))
    diameter = press.indenter.diameter
    begin = min(shape.starts(start_of(cells)), key=lambda q: abs(float(q[2]) - diameter / 2))
    try:
        q = fit_to(shape, cells, begin).q
    except NoAnswer:
        return None
    height = float(q[shape.height])
    ratios = q[shape.skirt] / height
    return [
        diameter,
        press.stretch,
        height,
        float(q[2]),
        float(q[shape.ratio]),
        *ratios.tolist(),
        diameter / 2 - float(q[2]),
    ]


def regress(rows: Array, use: tuple[int, ...]) -> Regression:
    """Return the regression of the last nine columns on features of the second to fourth."""
    at = features(rows[:, 1], rows[:, 2], rows[:, 3])[list(use)]
    center, scale = at.mean(axis=1), at.std(axis=1)
    exponents = powers(len(use), DEGREE)
    design = (((at.T - center) / scale)[:, None, :] ** exponents).prod(axis=2)
    coefficients = np.linalg.lstsq(design, rows[:, 4:], rcond=None)[0]
    left = rows[:, 4:] - design @ coefficients
    covariance = left.T @ left / (len(rows) - len(exponents))
    return Regression(use, center, scale, at.min(axis=1), at.max(axis=1), exponents, coefficients, covariance)


def prior_from(rows: Array) -> SkirtPrior:
    """Return the prior that rows of presses give."""
    return SkirtPrior(regress(rows, (0, 1, 2)), regress(rows, (1, 2)))


def table(wanted: Sequence[BodyPress]) -> Array:
    """Return the rows of all presses that could be fitted."""
    return np.array([row for row in map(row_of, wanted) if row is not None])


def left_out(rows: Array) -> Array:
    """Return the standard deviations (9,) of what the regression leaves of diameters that it has not seen."""
    missed = []
    for diameter in np.unique(rows[:, 0])[1:-1]:
        chosen = rows[:, 0] == diameter
        known = regress(rows[~chosen], (0, 1, 2))
        missed += [row[4:] - known.mean(features(row[1], row[2], row[3]))[0] for row in rows[chosen]]
    return np.asarray(np.std(missed, axis=0))


def main() -> None:
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else FILE
    rows = table(presses())
    file.write_text(prior_from(rows).to_json() + "\n", encoding="utf-8")
    print(
        f"{len(rows)} presses of {len(presses())}; standard deviation of what the regression leaves, diameter left out"
    )
    print("  ln ratio  seven coefficients over the depth                          radius mm")
    sd = left_out(rows)
    print(f"  {sd[0]:8.3f}  {'  '.join(f'{s:.3f}' for s in sd[1:8])}  {sd[8] * 1e3:8.3f}")
    print(f"written to {file}")


if __name__ == "__main__":
    main()
