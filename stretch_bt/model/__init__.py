"""Contact mechanics: Hertz contact, the calibrated force law of the hand, and what follows from force and height."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.model.calibration.calibrate import CALIBRATIONS as CALIBRATIONS
    from stretch_bt.model.calibration.calibrate import Calibration as Calibration
    from stretch_bt.model.calibration.calibrate import Fit as Fit
    from stretch_bt.model.calibration.calibrate import calibrate as calibrate
    from stretch_bt.model.calibration.characterization import Table as Table
    from stretch_bt.model.calibration.characterization import read_table as read_table
    from stretch_bt.model.calibration.measurements import Measurements as Measurements
    from stretch_bt.model.elastic_sphere import object_modulus as object_modulus
    from stretch_bt.model.force.calibrated import CalibratedHertz as CalibratedHertz
    from stretch_bt.model.force.calibrated import StretchState as StretchState
    from stretch_bt.model.force.force_model import ForceModel as ForceModel
    from stretch_bt.model.force.membrane import MembraneModel as MembraneModel
    from stretch_bt.model.hertz import hertz_depth as hertz_depth
    from stretch_bt.model.hertz import hertz_force as hertz_force
    from stretch_bt.model.palpation.active import COUNTS as COUNTS
    from stretch_bt.model.palpation.active import Costs as Costs
    from stretch_bt.model.palpation.active import Looks as Looks
    from stretch_bt.model.palpation.active import next_look as next_look
    from stretch_bt.model.palpation.indentation import next_indentation as next_indentation
    from stretch_bt.model.palpation.planning import Limits as Limits
    from stretch_bt.model.palpation.planning import NoHarderPress as NoHarderPress
    from stretch_bt.model.palpation.planning import next_press as next_press
    from stretch_bt.model.palpation.series import POWER as POWER
    from stretch_bt.model.palpation.series import ROBOT as ROBOT
    from stretch_bt.model.palpation.series import STIFFENING as STIFFENING
    from stretch_bt.model.palpation.series import Series as Series
    from stretch_bt.model.palpation.series import TopReading as TopReading
    from stretch_bt.model.palpation.series import fit_series as fit_series
    from stretch_bt.model.palpation.stiffness import estimate_stiffness as estimate_stiffness
    from stretch_bt.model.palpation.zero_force import drop_power as drop_power
    from stretch_bt.model.palpation.zero_force import undeformed_height as undeformed_height
    from stretch_bt.model.plastic_cube import cube_yield_stress as cube_yield_stress

_HOMES = {
    "CALIBRATIONS": "calibration.calibrate",
    "COUNTS": "palpation.active",
    "Costs": "palpation.active",
    "CalibratedHertz": "force.calibrated",
    "Calibration": "calibration.calibrate",
    "Fit": "calibration.calibrate",
    "ForceModel": "force.force_model",
    "Measurements": "calibration.measurements",
    "MembraneModel": "force.membrane",
    "calibrate": "calibration.calibrate",
    "cube_yield_stress": "plastic_cube",
    "Limits": "palpation.planning",
    "NoHarderPress": "palpation.planning",
    "Looks": "palpation.active",
    "POWER": "palpation.series",
    "STIFFENING": "palpation.series",
    "ROBOT": "palpation.series",
    "Series": "palpation.series",
    "StretchState": "force.calibrated",
    "TopReading": "palpation.series",
    "Table": "calibration.characterization",
    "drop_power": "palpation.zero_force",
    "estimate_stiffness": "palpation.stiffness",
    "fit_series": "palpation.series",
    "hertz_depth": "hertz",
    "hertz_force": "hertz",
    "next_indentation": "palpation.indentation",
    "object_modulus": "elastic_sphere",
    "next_look": "palpation.active",
    "next_press": "palpation.planning",
    "read_table": "calibration.characterization",
    "undeformed_height": "palpation.zero_force",
}
__all__ = [  # noqa: PLE0604
    *_HOMES,
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
