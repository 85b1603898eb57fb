"""The ladder of force models on one hand."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from statistics import median
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stretch_bt.accuracy.force.hands import FINER, STRETCHES, forces_of, measured_at
from stretch_bt.accuracy.job import Job
from stretch_bt.accuracy.points import Answer, Setting
from stretch_bt.accuracy.summary import rms
from stretch_bt.model.calibration.calibrate_hertz import effective_modulus, fit_calibrated_hertz
from stretch_bt.model.calibration.calibrate_membrane import fit_membrane
from stretch_bt.model.hertz import hertz_force
from stretch_bt.simulation.membrane.materials import NeoHookean
from stretch_bt.simulation.membrane.sheet.effects import DENSITY, Effects
from stretch_bt.simulation.membrane.sheet.geometry import Sheet
from stretch_bt.simulation.membrane.sheet.settings import Settings
from stretch_bt.simulation.scene.sections import MOUNT_PRESTRETCH, SHEAR_MODULUS

__all__ = ["MODELS", "jobs", "warm"]

Array = npt.NDArray[np.float64]
Call = Callable[[float, float, float], float]

SEED = 7
SHEET = Sheet(0.1, 0.09, 0.002, NeoHookean(SHEAR_MODULUS), MOUNT_PRESTRETCH, Effects(sag=DENSITY, bending=True))
HERTZ, PAPER = Setting("hertz", "one modulus"), Setting("calibrated", "the paper's law")
TABLE, SOLVED = Setting("membrane", "table"), Setting("sheet", "solved from the last press")
MODELS = (HERTZ, PAPER, TABLE, SOLVED)
_REFINEMENT = 1.4


class Plan(NamedTuple):
    """The measured states and the asked ones: lengths in m."""

    diameters: tuple[float, ...]
    stretches: tuple[float, ...]
    depths: tuple[float, ...]
    asked_diameters: tuple[float, ...]
    asked_stretches: tuple[float, ...]
    settings: Settings
    note: str = ""


_WIDE, _DEEP = (0.010, 0.020, 0.030, 0.045, 0.060), (0.001, 0.003, 0.005, 0.008, 0.011, 0.015)
FULL = Plan(
    _WIDE,
    tuple(float(x) for x in STRETCHES[[0, 1, 3, 5, 7]]),
    _DEEP,
    (0.013, 0.017, 0.025, 0.037, 0.052),
    (0.005, 0.025, 0.045, 0.07),
    FINER,
)
QUICK = Plan(
    _WIDE[::2],
    (0.0, 0.03, 0.08),
    _DEEP[1::2],
    (0.015, 0.037),
    (0.045,),
    Settings(coarsen=1.0),
    ", few presses measured",
)
ASKED = np.array([2.5, 4.5, 6.5, 9.5, 13.5]) * 1e-3


def warm() -> None:
    """Ask each model once, of a hand that is measured coarsely."""
    coarse = QUICK._replace(stretches=(0.03, 0.08), settings=Settings(coarsen=2.0))
    for call in _models(coarse).values():
        call(0.02, 0.045, 0.005)
    _models.cache_clear()


def jobs(quick: bool) -> Iterator[Job]:
    """Yield the error and the time of each model at each diameter and stretch."""
    plan = QUICK if quick else FULL
    presses = len(plan.diameters) * len(plan.stretches) * len(plan.depths)
    first = 0.1 * presses / (2 if quick else 1)
    for diameter in plan.asked_diameters:
        for stretch in plan.asked_stretches:
            case = f"{1e3 * diameter:.0f} mm, stretch {1e3 * stretch:.0f} mm{plan.note}"
            for setting in MODELS:
                asked = partial(_asked, plan, setting, diameter, stretch)
                yield Job(case, setting, "force", first + 0.1, asked, SEED, setting == TABLE, "hand")
                first = 0.0


@lru_cache(maxsize=2)
def _models(plan: Plan) -> dict[Setting, Call]:
    from stretch_bt.simulation.sheet_model import SheetModel

    known = np.array(plan.diameters), np.array(plan.stretches), np.array(plan.depths)
    given = measured_at(forces_of(SHEET, *known, plan.settings), *known, SEED)
    calibrated, membrane = fit_calibrated_hertz(given), fit_membrane(given)
    solved = SheetModel.from_json(membrane.to_json())
    modulus = effective_modulus(given.depth, given.force, given.radius).value
    return {
        HERTZ: lambda r, x, d: float(hertz_force("sphere", d, modulus, radius=r)),
        PAPER: lambda r, x, d: calibrated.predict(r, x, d)[0],
        TABLE: lambda r, x, d: membrane.predict(r, x, d)[0],
        SOLVED: lambda r, x, d: solved.predict(r, x, d)[0],
    }


@lru_cache(maxsize=2)
def _true(plan: Plan, diameter: float, stretch: float) -> tuple[Array, float]:
    """Return the hand's own forces, N, at the depths that are asked for, and their error as a part of them."""
    coarser = Settings(coarsen=_REFINEMENT * plan.settings.coarsen)
    own, other = (
        forces_of(SHEET, np.array([diameter]), np.array([stretch]), ASKED, settings)[0, 0]
        for settings in (plan.settings, coarser)
    )
    return own, rms(other / own - 1) / (_REFINEMENT - 1)


def _asked(plan: Plan, setting: Setting, diameter: float, stretch: float) -> list[Answer]:
    call = _models(plan)[setting]
    own, uncertain = _true(plan, diameter, stretch)
    call(diameter / 2, stretch, float(ASKED[0]))
    off, seconds = [], []
    for depth, force in zip(ASKED, own, strict=True):
        began = time.process_time_ns()
        found = call(diameter / 2, stretch, float(depth))
        seconds.append((time.process_time_ns() - began) * 1e-9)
        off.append(found / force - 1)
    return [Answer("force", rms(off), median(seconds), uncertain)]
