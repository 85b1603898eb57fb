"""Calibrating a hand: a force model fitted to measured forces, its residuals, and its errors at a diameter left out of the fit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from stretch_bt.arguments import check_kind
from stretch_bt.errors import InvalidInput, NoAnswer, shown
from stretch_bt.model.calibration.calibrate_hertz import fit_calibrated_hertz
from stretch_bt.model.calibration.calibrate_membrane import fit_membrane, within_table
from stretch_bt.model.calibration.depth_zero import DepthZero
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.force.calibrated import CalibratedHertz
from stretch_bt.model.force.force_model import PAPER, ForceModel, Range, model_of_kind

__all__ = ["CALIBRATIONS", "Calibration", "Fit", "LeftOut", "StateResidual", "calibrate", "leave_one_out"]

Fit = Callable[[Measurements, dict[str, Any] | None], ForceModel]


def _fit_sheet(given: Measurements, provenance: dict[str, Any] | None = None) -> ForceModel:
    """Return the model that solves the sheet, with the parameters of the membrane model."""
    return model_of_kind("sheet").from_json(fit_membrane(given, provenance).to_json())


def _guess_membrane(given: Measurements, provenance: dict[str, Any] | None = None) -> ForceModel:
    """Return the membrane model without an error of its own, which takes a fit for each diameter."""
    return fit_membrane(given, provenance, judged=False)


def _guess_sheet(given: Measurements, provenance: dict[str, Any] | None = None) -> ForceModel:
    return model_of_kind("sheet").from_json(_guess_membrane(given, provenance).to_json())


#: fits by the name of the model
CALIBRATIONS: dict[str, Fit] = {"membrane": fit_membrane, "paper": fit_calibrated_hertz, "sheet": _fit_sheet}
#: the same, for models of which only the forces are asked
_UNJUDGED: dict[str, Fit] = {"membrane": _guess_membrane, "paper": fit_calibrated_hertz, "sheet": _guess_sheet}


@dataclass(frozen=True, slots=True)
class StateResidual:
    """Residuals, measured less modelled force, at one diameter and stretch, m: mean and rms, N."""

    diameter: float
    stretch: float
    mean: float
    rms: float
    presses: int


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Errors of a model at a diameter, m, that it was not fitted to: mean absolute error, N, and rms as a part of the model's force.

    `rms_relative` is over depths of 5 mm and stretches of 10 mm and more, None where there are none; `extrapolated` is true
    where the diameter lies outside the others. A model may refuse: then both errors are None, and `reason` says why.
    """

    diameter: float
    extrapolated: bool
    mean_absolute: float | None
    rms_relative: float | None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Calibration:
    """A fitted model with its residuals, which count depths from the zero that the fit found, and the measurements `used` by it."""

    model: ForceModel
    residuals: tuple[StateResidual, ...]
    left_out: tuple[LeftOut, ...]
    used: Measurements = field(compare=False, repr=False)

    @property
    def zero(self) -> DepthZero:
        """How far the zero of measured depths is off."""
        return DepthZero.of(self.model.provenance)

    @property
    def warnings(self) -> list[str]:
        """Measurements that were left out of the fit, a text for each kind."""
        return [f"left out: {text}" for text in self.model.provenance.get("left_out", [])]

    def to_json(self) -> dict[str, Any]:
        """Return what `stretch-bt calibrate` prints."""
        return {
            "kind": self.model.kind,
            **self.model.to_json(),
            "warnings": self.warnings,
            "residuals": [asdict(r) for r in self.residuals],
            "leave_one_out": [asdict(r) for r in self.left_out],
        }


def calibrate(given: Measurements, model: str = "membrane", provenance: dict[str, Any] | None = None) -> Calibration:
    """Fit a model to measured forces.

    Raises
    ------
    InvalidInput
        There is no such model.
    IllConditioned
        The measurements do not determine it.
    """
    check_kind("given", given, Measurements, "`Measurements.of` makes one of a table")
    if provenance is not None:
        check_kind("provenance", provenance, dict)
    if not isinstance(model, str) or model not in CALIBRATIONS:
        raise InvalidInput(f"no model {shown(model)[:80]}; choose one of {', '.join(CALIBRATIONS)}")
    fitted = CALIBRATIONS[model](given, provenance)
    used = given if model == PAPER else within_table(given)[0]
    return Calibration(fitted, tuple(_residuals(fitted, used)), tuple(leave_one_out(used, _UNJUDGED[model])), used)


def leave_one_out(given: Measurements, fit: Fit) -> list[LeftOut]:
    """Return for each diameter the errors of a model fitted to the others; nothing where there is one diameter alone."""
    found = []
    for diameter in given.diameters if len(given.diameters) > 1 else ():
        mask = given.of_diameter(diameter)
        outer = diameter in (given.diameters[0], given.diameters[-1])
        try:
            pressed = given.where(mask & (given.depth > 0))
            if not len(pressed):
                found.append(LeftOut(diameter, outer, None, None, "it was not pressed deeper than first contact"))
                continue
            model = widened(fit(given.where(~mask), None), given)
            found.append(_told(model, pressed, diameter, outer))
        except NoAnswer as refusal:
            found.append(LeftOut(diameter, outer, None, None, f"no model of the other diameters: {refusal}"))
    return found


def widened(model: ForceModel, given: Measurements) -> ForceModel:
    """Return a model that also answers for the diameter left out: the paper's law refuses diameters past its own."""
    if not isinstance(model, CalibratedHertz):
        return model
    limits = Range(given.range.radius, given.range.stretch, given.range.depth)
    return replace(model, range=limits)


def _told(model: ForceModel, given: Measurements, diameter: float, outer: bool) -> LeftOut:
    told = forces(model, DepthZero.of(model.provenance).applied(given))
    off = told - given.force
    deep = (given.depth >= 5e-3 - 1e-9) & (given.stretch >= 10e-3 - 1e-9)
    relative = math.sqrt(float(np.mean((off[deep] / np.maximum(told[deep], 1e-3)) ** 2))) if deep.any() else None
    return LeftOut(diameter, outer, float(np.abs(off).mean()), relative)


def _residuals(model: ForceModel, given: Measurements) -> list[StateResidual]:
    found, zero = [], DepthZero.of(model.provenance)
    for diameter in given.diameters:
        for stretch in np.unique(given.stretch):
            of = given.where(given.of_diameter(diameter) & (given.stretch == stretch))
            if len(of):
                left = of.force - forces(model, zero.applied(of))
                rms = math.sqrt(float(np.mean(left**2)))
                found.append(StateResidual(diameter, float(stretch), float(left.mean()), rms, len(of)))
    return found
