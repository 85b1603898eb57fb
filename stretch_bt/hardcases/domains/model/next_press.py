"""The next press and the next look: none within the limits, none worth its time, and limits, costs and looks that are none."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.hardcases.domains.model.series import DROP, MODEL, RADIUS, TOP, Poses, fit, height, seen, spring
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import Costs, Limits, Looks, next_look, next_press

TOUCHES = ((0.0, 0.002), (0.0, 0.004), (0.0, 0.010))
LIMITS = Limits(lowest=TOP - 0.018, force=8.0, stretch=0.08, stretch_step=0.01)
STIFF = Limits(lowest=TOP - 0.010, force=8.0, stretch=0.0, stretch_step=0.01)
LOOKS = Looks(frame=3e-4, fixed=3e-5, robot=5e-5)


def _planned(stiffness: float, limits: Limits = LIMITS, sd: float = 2e-5, poses: Poses = TOUCHES) -> Any:
    readings = seen(spring(stiffness), sd, poses=poses)
    found = fit(readings)
    return found, next_press(MODEL, RADIUS.value, found, readings[-1], DROP, limits)


def _looked(stiffness: float, *, sd: float = 3e-5, poses: Poses = TOUCHES, limits: Limits = LIMITS, **more: Any) -> Any:
    readings = seen(spring(stiffness), sd, poses=poses)
    looks, costs = more.pop("looks", LOOKS), more.pop("costs", Costs())
    return next_look(MODEL, RADIUS.value, fit(readings), readings[-1], DROP, limits, looks, costs, **more)


def _hardest() -> list[float]:
    """Return stretch, how far the hand is above its lowest height, m, and drop over the wanted one of the last press there is."""
    limits = Limits(lowest=TOP - 0.012, force=8.0, stretch=0.02, stretch_step=0.01)
    found, plan = _planned(4000.0, limits)
    assert plan.force > found.force.value
    return [plan.stretch, plan.hand - limits.lowest, plan.drop / DROP]


def _past_it(stiffness: float) -> list[float]:
    """Return how far a planned press drops an object over the wanted drop, and the planned drop over that."""
    _, plan = _planned(stiffness, sd=5e-6)
    dropped = TOP - height(spring(stiffness), plan.stretch, plan.hand)
    return [dropped / DROP, plan.drop / dropped]


SLACK = replace(LIMITS, lowest=TOP - 0.0101)
LONG = replace(LOOKS, taken=1e4)
NO_HARDER = Refusal(IllConditioned, "no press within the limits of depth, force and stretch is harder")
NO_LOOK: dict[str, Callable[[], Any]] = {
    "no speed": lambda: Costs(speed=0.0),
    "a change that gives time": lambda: Costs(change=-1.0),
    "a frame NaN": lambda: Costs(frame=math.nan),
    "no noise": lambda: Looks(0.0, 3e-5, 5e-5),
    "a fixed error below 0": lambda: Looks(3e-4, -1.0, 5e-5),
    "looked at for ever": lambda: Looks(3e-4, 3e-5, 5e-5, math.inf),
    "no counts": lambda: _looked(600.0, counts=[]),
    "a look of no frames": lambda: _looked(600.0, counts=[0, 8]),
    "a gain below 0": lambda: _looked(600.0, least=-1.0),
}

CASES: tuple[Hard, ...] = (
    *group(
        "no press within the limits is harder, or reaches the drop that is wanted",
        {
            "the hardest there is": (
                _hardest,
                Check(
                    "all stretched, at the lowest height, short of it",
                    lambda f: f[0] == 0.02 and abs(f[1]) < 3e-4 and f[2] < 1,
                ),
            ),
            "none is harder": (
                lambda: _planned(
                    4000.0,
                    Limits(lowest=TOP - 0.012, force=8.0, stretch=0.02, stretch_step=0.01),
                    poses=[*TOUCHES, (0.02, 0.012)],
                ),
                NO_HARDER,
            ),
            "never gives way": (
                partial(_planned, 1e7, STIFF),
                Refusal(IllConditioned, r"gave way by .* too little to tell; its stiffness is above about"),
            ),
            "never gives way, look": (
                partial(_looked, 1e7, limits=STIFF),
                Refusal(IllConditioned, "too little to tell"),
            ),
            "too slack for the depth": (
                lambda: _planned(1100.0, replace(LIMITS, lowest=TOP - 0.011), 5e-6)[1],
                Check("stretched by 20 mm or more", lambda plan: plan.stretch >= 0.02 and plan.hand >= TOP - 0.011),
            ),
            "felt badly": (
                lambda: _planned(2500.0, sd=1.5e-4)[1].force / _planned(2500.0, sd=5e-6)[1].force,
                Range(0.1, 0.999),
            ),
            "a limit of stretch below the present one": (
                lambda: (
                    _looked(
                        600.0,
                        poses=[(0.02, 0.003), (0.02, 0.005), (0.02, 0.008)],
                        limits=replace(LIMITS, stretch=0.01),
                        least=0.0,
                    ).press
                ),
                Value(None),
            ),
            "nothing takes off enough": (partial(_looked, 600.0, least=100.0), Value(None)),
            "something takes off enough": (
                partial(_looked, 600.0, least=0.01),
                Check("a look", lambda choice: choice is not None),
            ),
            "a stretch is not worth its time": (
                partial(_looked, 1100.0, looks=LONG, at_press=True, limits=SLACK, costs=Costs(change=3000.0)),
                Value(None),
            ),
            "a stretch is worth its time": (
                lambda: _looked(1100.0, looks=LONG, at_press=True, limits=SLACK).press.stretch,
                Range(1e-3),
            ),
            "the depth is worth its time": (
                lambda: _looked(1100.0, looks=LONG, at_press=True).press.stretch,
                Value(0.0),
            ),
        },
        {
            f"one press past the drop, {stiffness:g} N/m": (
                partial(_past_it, stiffness),
                Check(
                    "past it by less than a quarter, as planned", lambda f: 1 <= f[0] < 1.27 and abs(f[1] - 1) < 0.05
                ),
            )
            for stiffness in (700.0, 1000.0, 1300.0)
        },
        prefix="next press, ",
    ),
    *group(
        "numbers that make no limits, costs or looks",
        {
            f"limits {wrong}": (partial(Limits, *wrong), Refusal(InvalidInput, "limits"))
            for wrong in (
                (math.nan, 8.0, 0.08, 0.01),
                (0.04, 0.0, 0.08, 0.01),
                (0.04, 8.0, -0.01, 0.01),
                (0.04, 8.0, 0.08, 0.0),
            )
        },
        {name: (make, Refusal(InvalidInput, "must be|need")) for name, make in NO_LOOK.items()},
        prefix="next press, ",
    ),
)
