"""The ladder of force models on one hand."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from statistics import median

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.force.hands import FINER, STRETCHES, forces_of, measured_at
from stretch_bt.accuracy.points import Point
from stretch_bt.model.calibration.calibrate_hertz import effective_modulus, fit_calibrated_hertz
from stretch_bt.model.calibration.calibrate_membrane import fit_membrane
from stretch_bt.model.calibration.measurements import Measurements
from stretch_bt.model.hertz import hertz_force
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

__all__ = ["points"]

Array = npt.NDArray[np.float64]
Call = Callable[[float, float, float], float]

DIAMETERS, DEPTHS = np.array([10, 20, 30, 45, 60]) * 1e-3, np.array([1, 3, 5, 8, 11, 15]) * 1e-3
SEED = 7


def points(quick: bool) -> Iterator[Point]:
    """Yield the error and the time of each model at each diameter and stretch."""
    effects = Effects(sag=DENSITY, bending=True)
    sheet = Sheet(0.1, 0.09, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, effects)
    known = STRETCHES[[0, 3, 7]] if quick else STRETCHES[[0, 1, 3, 5, 7]]
    true = forces_of(sheet, DIAMETERS, known, DEPTHS, FINER)
    models = _models(measured_at(true, DIAMETERS, known, DEPTHS, SEED))
    asked = (0.045,) if quick else (0.005, 0.025, 0.045, 0.07)
    for diameter in (0.015, 0.037) if quick else (0.013, 0.025, 0.037, 0.052):
        for stretch in asked:
            depths = np.array([2.5, 4.5, 6.5, 9.5, 13.5]) * 1e-3
            own = forces_of(sheet, np.array([diameter]), np.array([stretch]), depths, FINER)[0, 0]
            for name, call in models.items():
                yield _point(name, call, diameter, stretch, depths, own)


def _models(given: Measurements) -> dict[str, Call]:
    from stretch_bt.simulation.sheet_model import SheetModel

    calibrated, membrane = fit_calibrated_hertz(given), fit_membrane(given)
    solved = SheetModel.from_json(membrane.to_json())
    modulus = effective_modulus(given.depth, given.force, given.radius).value
    return {
        "hertz: one modulus": lambda r, x, d: float(hertz_force("sphere", d, modulus, radius=r)),
        "calibrated: paper": lambda r, x, d: calibrated.predict(r, x, d)[0],
        "membrane: table": lambda r, x, d: membrane.predict(r, x, d)[0],
        "sheet: warm": lambda r, x, d: solved.predict(r, x, d)[0],
    }


def _point(name: str, call: Call, diameter: float, stretch: float, depths: Array, own: Array) -> Point:
    call(diameter / 2, stretch, float(depths[0]))
    off, seconds = [], []
    for depth, force in zip(depths, own, strict=True):
        began = time.process_time_ns()
        told = call(diameter / 2, stretch, float(depth))
        seconds.append((time.process_time_ns() - began) * 1e-9)
        off.append(told / force - 1)
    case = f"{1e3 * diameter:.0f} mm, stretch {1e3 * stretch:.0f} mm"
    return Point(case, name, "force", float(np.sqrt(np.mean(np.square(off)))), median(seconds), seed=SEED)
