"""Contact mechanics: Hertz contact, the calibrated force law of the hand, and what follows from force and height."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stretch_bt.model.calibrated import CalibratedHertz as CalibratedHertz
    from stretch_bt.model.calibrated import StretchState as StretchState
    from stretch_bt.model.characterization import Table as Table
    from stretch_bt.model.characterization import read_table as read_table
    from stretch_bt.model.force_model import ForceModel as ForceModel
    from stretch_bt.model.hertz import hertz_depth as hertz_depth
    from stretch_bt.model.hertz import hertz_force as hertz_force
    from stretch_bt.model.indentation import next_indentation as next_indentation
    from stretch_bt.model.stiffness import estimate_stiffness as estimate_stiffness
    from stretch_bt.model.yielding import Yielding as Yielding
    from stretch_bt.model.yielding import fit_yielding as fit_yielding
    from stretch_bt.model.zero_force import undeformed_height as undeformed_height

_HOMES = {
    "CalibratedHertz": "calibrated",
    "ForceModel": "force_model",
    "StretchState": "calibrated",
    "Table": "characterization",
    "Yielding": "yielding",
    "estimate_stiffness": "stiffness",
    "fit_yielding": "yielding",
    "hertz_depth": "hertz",
    "hertz_force": "hertz",
    "next_indentation": "indentation",
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
