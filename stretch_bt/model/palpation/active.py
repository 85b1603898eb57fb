"""Where to press next and how long to look, so that the stiffness becomes known best for the robot's time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_each, check_kind
from stretch_bt.errors import IllConditioned, InvalidInput, shown
from stretch_bt.model.force.force_model import ForceModel
from stretch_bt.model.force.local import LocalReading
from stretch_bt.model.palpation.balance import LAW
from stretch_bt.model.palpation.planning import (
    MARGIN,
    Limits,
    Plan,
    check_asked,
    hardest_trusted,
    next_press,
    off_by,
    press_at,
    stretches,
)
from stretch_bt.model.palpation.series import Series
from stretch_bt.plain_numbers import is_number

__all__ = ["COUNTS", "Choice", "Costs", "Looks", "next_look"]

Array = npt.NDArray[np.float64]

COUNTS = (8, 16, 32, 64)  # numbers of frames that a look may take
FORCES = 10  # presses to choose from at each stretch
STEP = 1e-5  # m, over which a slope is taken
UNTOLD = 16  # frames of a look while the object's drop is not significant yet


@dataclass(frozen=True, slots=True)
class Costs:
    """The robot's time: speed of a press, m/s; for leaving, stretching and coming back, for each frame, and for settling at each new press, s."""

    speed: float = 0.005
    change: float = 3.5
    frame: float = 1 / 30
    settle: float = 0.0

    def __post_init__(self) -> None:
        values = (self.speed, self.change, self.frame, self.settle)
        if not all(map(is_number, values)) or min(self.speed, self.frame) <= 0 or min(self.change, self.settle) < 0:
            raise InvalidInput(f"costs need a speed and a time of a frame above 0, and no time below 0 s, got {self}")

    def most_by_stretching(self, count: int) -> float:
        """Return a bound of the gain, 1/s, of a press at another stretch: all of the variance in the least time of such a look."""
        return 1 / max(self.change + self.settle + count * self.frame, 1e-9)

    def seconds(self, last: LocalReading, plan: Plan | None, count: int) -> float:
        """Return the time of going to a press, or staying, and looking at so many frames, s."""
        if plan is None:
            return count * self.frame
        away = abs(last.hand - plan.hand) / self.speed
        return away + (self.change if plan.stretch != last.stretch else 0.0) + self.settle + count * self.frame


@dataclass(frozen=True, slots=True)
class Looks:
    """Errors of a look: sd of a height in one frame, the sd that no averaging takes away, and the sd of the hand's place, m.

    `taken` frames were already averaged at the present press.
    """

    frame: float
    fixed: float
    robot: float
    taken: float = 0.0

    def __post_init__(self) -> None:
        values = (self.frame, self.fixed, self.robot, self.taken)
        if not all(map(is_number, values)) or self.frame <= 0 or min(values) < 0:
            raise InvalidInput(f"looks need an sd of a frame above 0 m, and none of their numbers below 0, got {self}")


@dataclass(frozen=True, slots=True)
class Choice:
    """The next look. `press` is None where the hand stays where it is.

    `gain` is the part of the variance of the stiffness that the look should take away, per second, 1/s;
    `relative_sd` the standard deviation that is then left, as a part of the stiffness.
    """

    press: Plan | None
    count: int
    seconds: float
    gain: float
    relative_sd: float


def next_look(
    model: ForceModel,
    radius: float,
    fit: Series,
    last: LocalReading,
    drop: float,
    limits: Limits,
    looks: Looks,
    costs: Costs = Costs(),
    *,
    counts: Sequence[int] = COUNTS,
    least: float = 0.01,
    at_press: bool = False,
) -> Choice | None:
    """Return the look that takes most off the variance of the stiffness per second, or None where none takes off enough.

    Force over drop has the relative variance r C r' + f^2, C the fit's covariance of q = (top, compliance, power, stiffening), r the derivative of
    its logarithm by q, and f the error of the force model and the radius, which no look changes. A look at a press whose height
    has the derivative a by q and the sd s leaves C - C a' a C / (s^2 + a C a'). The choices are the present press and, at each
    stretch from it on, forces from three standard deviations above the last one's to where the fit is still trusted. The errors of the
    hand's place and of the model at a press are the same in all looks at it: staying reduces the frames' noise alone.

    While the object's drop is not significant, `next_press` chooses the press; the look takes 16 frames or the nearest of `counts`.

    Parameters
    ----------
    model, radius, fit, last, limits
        As in `next_press`.
    drop
        Drop at which the stiffness is wanted, m; no press is sent to where the object may drop twice as far.
    counts
        Numbers of frames to choose from.
    least
        Part of the variance per second, 1/s, below which a look is not worth its time.
    at_press
        Whether the stiffness is wanted at the last press, whichever that then is, and not at `drop`.

    Raises
    ------
    IllConditioned
        The drop is not significant, and nothing within the limits presses harder.
    InvalidInput
        A number is not finite or has the wrong sign.
    """
    check_asked(model, radius, fit, last, drop, limits)
    check_kind("looks", looks, Looks)
    check_kind("costs", costs, Costs)
    check_each("counts", counts, int)
    if not counts or min(counts) < 1 or not (is_number(least) and least >= 0):
        raise InvalidInput(
            f"counts must be 1 or more and least at least 0 1/s, not {tuple(counts)} and {shown(least)[:80]}"
        )
    try:
        fit.force_at(drop)
    except IllConditioned:
        return _untold(next_press(model, radius, fit, last, drop, limits), last, costs, counts)
    target = None if at_press else _of_logarithm(fit, drop)
    before = _spread(fit, _view(model, radius, fit, last, None, looks).secant if target is None else target)

    def weighed(plans: Sequence[Plan | None]) -> list[Choice]:
        views = [_view(model, radius, fit, last, plan, looks) for plan in plans]
        return [_weighed(fit, before, target, view, last, costs, looks, count) for view in views for count in counts]

    options = stretches(last.stretch, limits)
    choices = weighed([None, *_presses(model, radius, fit, last, drop, limits, options[:1])])
    if max(choice.gain for choice in choices) < costs.most_by_stretching(min(counts)):
        choices += weighed(_presses(model, radius, fit, last, drop, limits, options[1:]))
    best = max(choices, key=lambda choice: choice.gain)
    return best if best.gain > least else None


def _untold(plan: Plan, last: LocalReading, costs: Costs, counts: Sequence[int]) -> Choice:
    count = min(counts, key=lambda n: abs(n - UNTOLD))
    seconds = costs.seconds(last, plan, count)
    return Choice(plan, count, seconds, 1 / seconds, 1.0)


def _of_logarithm(fit: Series, drop: float) -> Array:
    """Return the derivative (4,) of the logarithm of the force at a drop by top, compliance, power and stiffening."""
    return np.array([0.0, *fit.law.log_force(drop)[1]])


def _presses(
    model: ForceModel, radius: float, fit: Series, last: LocalReading, drop: float, limits: Limits, choice: list[float]
) -> list[Plan]:
    """Return presses at some stretches within the limits, each harder than the last by three standard deviations or more."""
    found = []
    most = hardest_trusted(fit, drop, limits.force)
    for stretch in choice:
        low = fit.force.value + MARGIN * off_by(model, radius, fit, last, stretch)
        if low < most:
            plans = (press_at(model, radius, fit, stretch, float(f), limits) for f in np.geomspace(low, most, FORCES))
            found += [plan for plan in plans if plan is not None]
    return found


@dataclass(frozen=True, slots=True)
class _View:
    """A press: derivatives of its height (4,) and of the logarithm of force over drop (4,) by q, and the error common to all looks, m."""

    plan: Plan | None
    row: Array
    secant: Array
    alike: float


def _view(model: ForceModel, radius: float, fit: Series, last: LocalReading, plan: Plan | None, looks: Looks) -> _View:
    stretch, hand, force = (plan.stretch, plan.hand, plan.force) if plan else (last.stretch, last.hand, fit.force.value)
    drops, exponents, by_law = fit.law.deflection(np.log(np.array([force / fit.reference])))
    drop, power = float(drops[0]), float(exponents[0])
    slope, model_sd = _slope(model, radius, stretch, fit.top.value - drop - hand)
    steep = drop * slope / (force * power)
    row = np.array([1.0, *-by_law[0]]) / (1 + steep)
    secant = slope / force * row - (np.eye(LAW)[0] - row) / drop
    gain = steep / (1 + steep)  # derivative of the top's height by the hand's: a look measures their difference
    by_model = drop * model_sd / force / power * (1 - gain)
    return _View(plan, row, secant, math.hypot(looks.fixed, looks.robot * (1 - gain), by_model))


def _slope(model: ForceModel, radius: float, stretch: float, depth: float) -> tuple[float, float]:
    """Return how the model's force grows with depth there, N/m, and its sd, N."""
    low, high = model.range.depth
    depth = min(max(depth, low + STEP), high)
    force, sd = model.predict(radius, stretch, depth)
    return (force - model.predict(radius, stretch, depth - STEP)[0]) / STEP, sd


def _spread(fit: Series, slopes: Array) -> float:
    """Return the relative variance of a quantity whose logarithm has these derivatives by q."""
    return float(slopes @ fit.covariance @ slopes) + fit.force_sd**2


def _weighed(
    fit: Series,
    before: float,
    target: Array | None,
    view: _View,
    last: LocalReading,
    costs: Costs,
    looks: Looks,
    count: int,
) -> Choice:
    """Return a look with its reduction of the variance that there was before."""
    slopes = view.secant if target is None else target
    noise = max(fit.chi2, 1.0) * _variance(view.alike, looks, view.plan is None, count)
    told = fit.covariance @ view.row
    after = _spread(fit, slopes) - float(slopes @ told) ** 2 / (noise + float(view.row @ told))
    seconds = costs.seconds(last, view.plan, count)
    return Choice(view.plan, count, seconds, (before - after) / before / seconds, math.sqrt(max(after, 0.0)))


def _variance(alike: float, looks: Looks, stays: bool, count: int) -> float:
    """Return the variance, m^2, that a look's height has beside the frames already taken at its press."""
    own = looks.frame**2
    if not (stays and looks.taken > 0):
        return alike**2 + own / count
    known, then = (1 / (alike**2 + own / frames) for frames in (looks.taken, looks.taken + count))
    return 1 / (then - known)
