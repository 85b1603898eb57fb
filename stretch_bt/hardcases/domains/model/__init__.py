"""Contact mechanics: formulas, force models, palpation, calibration and control at the ends of what they know."""

from stretch_bt.hardcases.domains.model import calibration, closed_forms, control, force_models, palpation

__all__ = ["CASES"]

CASES = (*closed_forms.CASES, *force_models.CASES, *palpation.CASES, *calibration.CASES, *control.CASES)
