"""Contact mechanics: Hertz contact, the calibrated force law of the hand, and what follows from force and height."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.model.active import COUNTS as COUNTS
    from stretch_bt.model.active import Costs as Costs
    from stretch_bt.model.active import Looks as Looks
    from stretch_bt.model.active import next_look as next_look
    from stretch_bt.model.calibrated import CalibratedHertz as CalibratedHertz
    from stretch_bt.model.calibrated import StretchState as StretchState
    from stretch_bt.model.calibration import CALIBRATIONS as CALIBRATIONS
    from stretch_bt.model.calibration import Calibration as Calibration
    from stretch_bt.model.calibration import Fit as Fit
    from stretch_bt.model.calibration import calibrate as calibrate
    from stretch_bt.model.characterization import Table as Table
    from stretch_bt.model.characterization import read_table as read_table
    from stretch_bt.model.elastic_sphere import object_modulus as object_modulus
    from stretch_bt.model.force_model import ForceModel as ForceModel
    from stretch_bt.model.hertz import hertz_depth as hertz_depth
    from stretch_bt.model.hertz import hertz_force as hertz_force
    from stretch_bt.model.indentation import next_indentation as next_indentation
    from stretch_bt.model.measurements import Measurements as Measurements
    from stretch_bt.model.membrane import MembraneModel as MembraneModel
    from stretch_bt.model.planning import Limits as Limits
    from stretch_bt.model.planning import next_press as next_press
    from stretch_bt.model.series import POWER as POWER
    from stretch_bt.model.series import ROBOT as ROBOT
    from stretch_bt.model.series import Series as Series
    from stretch_bt.model.series import TopReading as TopReading
    from stretch_bt.model.series import fit_series as fit_series
    from stretch_bt.model.stiffness import estimate_stiffness as estimate_stiffness
    from stretch_bt.model.zero_force import undeformed_height as undeformed_height

_HOMES = {
    "CALIBRATIONS": "calibration",
    "COUNTS": "active",
    "Costs": "active",
    "CalibratedHertz": "calibrated",
    "Calibration": "calibration",
    "Fit": "calibration",
    "ForceModel": "force_model",
    "Measurements": "measurements",
    "MembraneModel": "membrane",
    "calibrate": "calibration",
    "Limits": "planning",
    "Looks": "active",
    "POWER": "series",
    "ROBOT": "series",
    "Series": "series",
    "StretchState": "calibrated",
    "TopReading": "series",
    "Table": "characterization",
    "estimate_stiffness": "stiffness",
    "fit_series": "series",
    "hertz_depth": "hertz",
    "hertz_force": "hertz",
    "next_indentation": "indentation",
    "object_modulus": "elastic_sphere",
    "next_look": "active",
    "next_press": "planning",
    "read_table": "characterization",
    "undeformed_height": "zero_force",
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
