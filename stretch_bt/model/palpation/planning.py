"""Where to press next, so that a soft object gives way by as much as is wanted and the force never falls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind, check_numbers
from stretch_bt.errors import IllConditioned, InvalidInput, NoEquilibrium, shown
from stretch_bt.model.force.force_model import ForceModel, check_model
from stretch_bt.model.force.local import LocalReading
from stretch_bt.model.palpation.indentation import next_indentation
from stretch_bt.model.palpation.series import ROBOT, Series
from stretch_bt.plain_numbers import is_number
from stretch_bt.quantity_text import format_quantity
from stretch_bt.units import KINDS, Estimate

__all__ = [
    "MARGIN",
    "Limits",
    "NoHarderPress",
    "Plan",
    "hardest_trusted",
    "next_press",
    "off_by",
    "press_at",
    "stretches",
]

MARGIN = 3.0  # standard deviations from the last force to the next, at least
PAST = 0.5  # standard deviations from the wanted drop to the planned one
TOO_FAR = 2.0  # times the wanted drop; the planned drop stays two standard deviations below this
GROWTH = 6.0  # times the last force, the most that the next one is
RATIO = 0.01  # relative error of the model's ratio of forces at two stretches
SPARE = 0.9  # part of the largest force that is planned for: a model is off by some per cent, and so is a wrench
STEP = 1e-5  # m
INSIDE = 5e-4  # m; distance of a press from the deepest that the model knows, so that its readings lie within the range
CLOSE = 1e-4  # relative tolerance of the hardest press's force


@dataclass(frozen=True, slots=True)
class Limits:
    """How far the hand may go: m, N. `lowest` is the world height down to which its flat membrane may be sent."""

    lowest: float
    force: float
    stretch: float
    stretch_step: float

    def __post_init__(self) -> None:
        if not all(map(is_number, (self.lowest, self.force, self.stretch, self.stretch_step))):
            raise InvalidInput(f"limits must be finite, got {self}")
        if self.force <= 0 or self.stretch < 0 or self.stretch_step <= 0:
            raise InvalidInput(f"limits need a force and a stretch step above 0, got {self}")


@dataclass(frozen=True, slots=True)
class Plan:
    """The next press: stretch, world height of the hand, m; the force, N, and the drop, m, that are expected there."""

    stretch: float
    hand: float
    force: float
    drop: float


class NoHarderPress(IllConditioned):
    """No press within the limits is harder than the latest."""


def check_asked(model: ForceModel, radius: float, fit: Series, last: LocalReading, drop: float, limits: Limits) -> None:
    """Raise InvalidInput for an argument that is no model, fit, reading or limits, or no number."""
    check_model(model)
    check_numbers("in m", radius=radius, drop=drop)
    check_kind("fit", fit, Series, "`fit_series` makes one")
    check_kind("limits", limits, Limits)
    try:
        numbers = last.stretch, last.hand, last.height, last.sd
    except AttributeError:
        raise InvalidInput(f"last is the last reading, a TopReading, not {shown(last)[:80]}") from None
    if not all(map(is_number, numbers)):
        raise InvalidInput(f"the numbers of the last reading must be finite, m, not {numbers}")


def next_press(
    model: ForceModel,
    radius: float,
    fit: Series,
    last: LocalReading,
    drop: float,
    limits: Limits,
    *,
    needed: float | None = None,
) -> Plan:
    """Return the press at which the object passes a drop, m, by the fit, or the nearest press that is allowed.

    The force aimed at is the least whose drop exceeds the wanted one by half a standard deviation of the fit there. It stays below
    the force at which the object, if softer by two standard deviations, would drop twice as far, and exceeds the last force by three
    standard deviations of their difference. The present stretch is kept while that force is within reach; else the least further
    stretch, in whole steps, is taken at which it is, or failing that the hardest press there is. `needed`, m, is the least deflection
    that is asked for, which the error names.

    Raises
    ------
    IllConditioned
        Nothing within the limits presses harder than the last press.
    """
    check_asked(model, radius, fit, last, drop, limits)
    if needed is not None:
        check_numbers("in m", needed=needed)
    wanted = _aim(fit, drop, limits.force)
    for stretch in stretches(last.stretch, limits):
        least = fit.force.value + MARGIN * off_by(model, radius, fit, last, stretch)
        planned = press_at(model, radius, fit, stretch, max(wanted, least), limits)
        if planned is not None:
            return planned
    hardest = _hardest(model, radius, fit, last, limits)
    if hardest is None:
        raise NoHarderPress(
            f"no press within the limits of depth, force and stretch is harder than this one; {fit.too_little()}"
            if fit.drop.value <= MARGIN * fit.drop.sd
            else f"the object gave way by {fit.drop.value * 1e3:.2f} mm of {(needed or drop) * 1e3:.2f} mm under {fit.force.value:.2f} N, which is "
            f"{format_quantity(fit.force.value / fit.drop.value, KINDS['Stiffness'])}, and "
            "no press within the limits of depth, force and stretch is harder; raise one of them, or ask for a smaller drop"
        )
    return hardest


def _aim(fit: Series, drop: float, most: float) -> float:
    """Return the force, N, at which the object passes the drop by the fit, as far as the fit may be trusted."""
    forces, expected = _ahead(fit)
    passing = [i for i, e in enumerate(expected) if e.value - PAST * e.sd >= drop]
    last = _furthest(expected, drop)
    chosen = float(forces[min(passing[0], last) if passing else last])
    return min(chosen, SPARE * most)


def hardest_trusted(fit: Series, drop: float, most: float) -> float:
    """Return the largest force, N, at which an object softer by two standard deviations drops no further than twice a drop, m."""
    forces, expected = _ahead(fit)
    return min(float(forces[_furthest(expected, drop)]), SPARE * most)


def _ahead(fit: Series) -> tuple[npt.NDArray[np.float64], list[Estimate]]:
    """Return forces from the last press' on, N, and the drops expected there."""
    forces = fit.force.value * np.geomspace(1.0, GROWTH, 90)
    return forces, [fit.drop_at(float(force)) for force in forces]


def _furthest(expected: list[Estimate], drop: float) -> int:
    return max((i for i, e in enumerate(expected) if e.value + 2 * e.sd <= TOO_FAR * drop), default=0)


def stretches(now: float, limits: Limits) -> list[float]:
    """Return the stretches, m, from the present one on that the limits allow."""
    steps = math.floor((limits.stretch - now) / limits.stretch_step + 1e-9)
    return [now + i * limits.stretch_step for i in range(steps + 1)]


def off_by(model: ForceModel, radius: float, fit: Series, last: LocalReading, stretch: float) -> float:
    """Return the standard deviation, N, of a force at a stretch less the force at the last press, when both should be one."""
    depth = fit.height.value - last.hand
    here = _slope(model, radius, last.stretch, depth)
    try:
        there = _slope(model, radius, stretch, model.depth_for(radius, stretch, fit.force.value))
    except NoEquilibrium:
        there = here
    height = fit.height.sd
    return math.hypot((here - there) * height, math.sqrt(2) * ROBOT * there, RATIO * fit.force.value)


def _slope(model: ForceModel, radius: float, stretch: float, depth: float) -> float:
    low, high = model.range.depth
    depth = min(max(depth, low + STEP), high)
    return (model.predict(radius, stretch, depth)[0] - model.predict(radius, stretch, depth - STEP)[0]) / STEP


def press_at(
    model: ForceModel, radius: float, fit: Series, stretch: float, force: float, limits: Limits
) -> Plan | None:
    """Return the press with this force at this stretch, or None where it is out of reach."""
    if force > limits.force:
        return None
    try:
        depth = next_indentation(model, radius, stretch, force)
    except NoEquilibrium:
        return None
    if depth > model.range.depth[1] - INSIDE:
        return None
    drop = max(fit.drop_at(force).value, 0.0)
    hand = fit.top.value - drop - depth
    return Plan(stretch, hand, force, drop) if hand >= limits.lowest else None


def _hardest(model: ForceModel, radius: float, fit: Series, last: LocalReading, limits: Limits) -> Plan | None:
    """Return the hardest press within the limits, or None where it is not harder than the last one by three standard deviations."""
    found: Plan | None = None
    for stretch in stretches(last.stretch, limits):
        low = fit.force.value + MARGIN * off_by(model, radius, fit, last, stretch)
        plan = press_at(model, radius, fit, stretch, low, limits)
        high = SPARE * limits.force
        while plan is not None and high - low > CLOSE * low:
            middle = (low + high) / 2
            harder = press_at(model, radius, fit, stretch, middle, limits)
            low, high, plan = (low, middle, plan) if harder is None else (middle, high, harder)
        if plan is not None and (found is None or plan.force > found.force):
            found = plan
    return found
