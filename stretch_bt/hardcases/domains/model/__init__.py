"""Contact mechanics: formulas, force models, palpation, calibration and control at the ends of their ranges."""

from stretch_bt.hardcases.domains.model import (
    calibration,
    closed_forms,
    control,
    force_files,
    force_models,
    next_press,
    series,
    shortcuts,
    tables,
)

__all__ = ["CASES"]

_PARTS = (closed_forms, force_models, force_files, series, next_press, shortcuts, calibration, tables, control)

CASES = tuple(hard for part in _PARTS for hard in part.CASES)
