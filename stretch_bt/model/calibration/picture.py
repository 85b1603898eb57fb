"""Pictures of a calibration: forces with the model's curves, effective moduli, and residuals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stretch_bt.errors import MissingExtra
from stretch_bt.model.calibration.calibrate_hertz import effective_modulus, moduli
from stretch_bt.model.calibration.depth_zero import DepthZero
from stretch_bt.model.calibration.measurements import Measurements, forces
from stretch_bt.model.force.force_model import ForceModel

__all__ = ["draw_calibration", "save_calibration"]


def save_calibration(model: ForceModel, given: Measurements, path: str | Path) -> None:
    """Draw into a file of the kind that its name ends with, such as .png or .svg.

    Raises
    ------
    MissingExtra
        matplotlib is not installed.
    """
    draw_calibration(model, given).savefig(path, dpi=120)


def draw_calibration(model: ForceModel, given: Measurements) -> Any:
    """Return a figure: a panel of force against depth for each diameter, effective modulus, and residuals.

    Depths count from the zero that the fit found.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra("pictures of a calibration need matplotlib: pip install 'stretch-bt[plot]'") from None

    given = DepthZero.of(model.provenance).applied(given)
    diameters = given.diameters
    figure = Figure(figsize=(4 * len(diameters), 8), layout="constrained")
    axes = figure.subplots(2, max(len(diameters), 2), squeeze=False)
    stretches = np.unique(given.stretch)
    for panel, diameter in zip(axes[0], diameters, strict=False):
        _curves(panel, model, given.where(given.of_diameter(diameter)), diameter, stretches)
    _moduli(axes[1][0], model, given)
    _residuals(axes[1][1], model, given)
    for panel in [*axes[0][len(diameters) :], *axes[1][2:]]:
        panel.set_axis_off()
    return figure


def _curves(panel: Any, model: ForceModel, given: Measurements, diameter: float, stretches: Any) -> None:
    depths = np.linspace(0.0, given.depth.max(), 60)
    for k, stretch in enumerate(stretches):
        color, at = _color(k, len(stretches)), given.stretch == stretch
        shown = depths[depths <= model.deepest(diameter / 2, float(stretch))]
        told = [model.predict(diameter / 2, float(stretch), float(d))[0] for d in shown]
        panel.plot(1e3 * shown, told, color=color, lw=1)
        panel.plot(1e3 * given.depth[at], given.force[at], ".", color=color, ms=3, label=f"{1e3 * stretch:.0f}")
    panel.set(title=f"{1e3 * diameter:.0f} mm", xlabel="depth, mm", ylabel="force, N")
    panel.legend(title="stretch, mm", fontsize=6, title_fontsize=6)


def _moduli(panel: Any, model: ForceModel, given: Measurements) -> None:
    """Draw E* by stretch for each diameter: of the presses, and of the model at the same depths."""
    diameter, stretch, modulus, sd = moduli(given)
    for k, each in enumerate(given.diameters):
        of, color = np.isclose(diameter, each), _color(k, len(given.diameters))
        panel.errorbar(
            1e3 * stretch[of], modulus[of] / 1e3, sd[of] / 1e3, fmt=".", color=color, label=f"{1e3 * each:.0f}"
        )
        panel.plot(
            1e3 * stretch[of], [_modulus(model, given, each, float(x)) / 1e3 for x in stretch[of]], color=color, lw=1
        )
    panel.set(xlabel="stretch, mm", ylabel="effective modulus, kPa")
    panel.legend(title="diameter, mm", fontsize=6, title_fontsize=6)


def _modulus(model: ForceModel, given: Measurements, diameter: float, stretch: float) -> float:
    of = given.where(given.of_diameter(diameter) & (given.stretch == stretch))
    return effective_modulus(of.depth, forces(model, of), diameter / 2).value


def _residuals(panel: Any, model: ForceModel, given: Measurements) -> None:
    for k, diameter in enumerate(given.diameters):
        of = given.where(given.of_diameter(diameter))
        panel.plot(
            1e3 * of.depth, 1e3 * (of.force - forces(model, of)), ".", ms=3, color=_color(k, len(given.diameters))
        )
    panel.axhline(0.0, color="black", lw=0.5)
    panel.set(xlabel="depth, mm", ylabel="measured less model, mN")


def _color(k: int, count: int) -> tuple[float, float, float]:
    """Return a colour from blue to red."""
    part = k / max(count - 1, 1)
    return 0.1 + 0.75 * part, 0.3 * (1 - abs(2 * part - 1)) + 0.15, 0.75 - 0.6 * part
