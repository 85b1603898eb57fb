"""Shortcuts that leave out parts to save time, or since they do not count: the answer must be the same as from all parts."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned
from stretch_bt.hardcases.domains.model.next_press import LIMITS, LOOKS, TOUCHES
from stretch_bt.hardcases.domains.model.series import DROP, MODEL, RADIUS, TOP, fit, height, seen, spring
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import Hard, group
from stretch_bt.model import Costs, TopReading, next_look
from stretch_bt.model.calibration.measurements import Measurements
from stretch_bt.model.palpation import active
from stretch_bt.model.palpation.planning import stretches
from stretch_bt.model.palpation.reloading import of_first_loading

#: the object gives way more only under a membrane that is stretched
SHALLOW = replace(LIMITS, lowest=TOP - 0.0115)


def _against_all(stiffness: float, change: float) -> float:
    """Return the gain of the chosen look over the largest of all presses at all stretches, and of staying."""
    readings, costs = seen(spring(stiffness), 3e-5, poses=TOUCHES), Costs(change=change)
    found, last, radius = fit(readings), readings[-1], RADIUS.value
    chosen = next_look(MODEL, radius, found, last, DROP, SHALLOW, LOOKS, costs, least=0.0)
    target = active._of_logarithm(found, DROP)
    plans = active._presses(MODEL, radius, found, last, DROP, SHALLOW, stretches(last.stretch, SHALLOW))
    views = [active._view(MODEL, radius, found, last, plan, LOOKS) for plan in (None, *plans)]
    before = active._spread(found, target)
    gains = [
        active._weighed(found, before, target, view, last, costs, LOOKS, count).gain
        for view in views
        for count in active.COUNTS
    ]
    assert chosen is not None
    return chosen.gain / max(gains)


def _sunk(by: float, kinds: str = "AAAAA", last: str = "A") -> tuple[int, Any]:
    """Return how many readings are of first loading, where the last ones were under less force and the top stood lower by so much, m."""
    law = spring(600.0)
    again = TopReading(0.0, TOP - 0.004, height(law, 0.0, TOP - 0.004) - by, 2e-5)
    readings = [*seen(law, 2e-5), *(replace(again) for _ in last)]
    names = {id(reading): kind for reading, kind in zip(readings, kinds + last, strict=True)}
    first, series = of_first_loading(
        readings, fit(readings), fit, MODEL, RADIUS.value, 5e-5, kind=lambda reading: names[id(reading)]
    )
    return len(first), series


def _seconds() -> list[float]:
    """Return the times of looks of ten frames: at once, 20 mm farther, at another stretch, and both, s."""
    costs, here = Costs(speed=0.01, change=2.0, frame=0.1, settle=0.5), _at(0.0, 0.05)
    plans = (None, _at(0.0, 0.03), _at(0.02, 0.05), _at(0.02, 0.07))
    return [costs.seconds(here, plan, 10) for plan in plans]


def _at(stretch: float, hand: float) -> Any:
    return SimpleNamespace(stretch=stretch, hand=hand)


def _below_nothing(stretch: float, depth: float) -> list[float]:
    """Return stretch and depth of a press that was measured beside others, as a calibration takes it."""
    table: Any = SimpleNamespace(
        geometry=np.array(["sphere"] * 3),
        size=np.full(3, 0.06),
        stretch=np.array([stretch, 0.02, 0.04]),
        depth=np.array([depth, 0.005, 0.01]),
        force=np.arange(3.0),
        force_sd=np.full(3, 0.01),
        provenance={},
    )
    made = Measurements.of(table)
    return [float(v) for v in (*made.stretch, *made.depth)]


SAID = Refusal(IllConditioned, "the object did not come back as it went")
CASES: tuple[Hard, ...] = (
    *group(
        "presses at other stretches are weighed only where they may be worth more than the best one so far",
        {
            f"the best of all looks, {stiffness:g} N/m, {change:g} s for a stretch": (
                partial(_against_all, stiffness, change),
                Range(1 - 1e-12, 1 + 1e-12),
            )
            for stiffness in (300.0, 1100.0)
            for change in (0.0, 0.5, 3.5)
        },
        {
            "what looks take": (
                _seconds,
                Value([1.0, 2.0 + 0.5 + 1.0, 2.0 + 0.5 + 1.0, 2.0 + 2.0 + 0.5 + 1.0], rel=1e-12),
            )
        },
    ),
    *group(
        "an object that did not come back shows it in readings under less force than before, of the same kind as the latest",
        {
            "it came back": (partial(_sunk, 0.0), Check("all 6 readings", lambda found: found[0] == 6)),
            "it did not come back": (partial(_sunk, 1e-3), SAID),
            "another kind of reading": (
                partial(_sunk, 1e-3, "AAAAA", "B"),
                Check("all 6 readings", lambda found: found[0] == 6),
            ),
            "a kind that came before": (
                partial(_sunk, 1e-3, "BBBAA", "B"),
                Check("all 6 readings", lambda found: found[0] == 6),
            ),
            "the latest of another kind": (
                partial(_sunk, 1e-3, "AAAAA", "AB"),
                Check("all 7 readings", lambda found: found[0] == 7),
            ),
            "the kind of the latest": (partial(_sunk, 1e-3, "BBBBA", "A"), SAID),
        },
    ),
    *group(
        "a gripper and a hand may read a little below zero, and zero is meant",
        {
            "a stretch below 0": (
                partial(_below_nothing, -1e-4, 0.002),
                Value([0.0, 0.02, 0.04, 0.002, 0.005, 0.01], abs=1e-12),
            ),
            "a depth below 0": (
                partial(_below_nothing, 0.0, -1e-4),
                Value([0.0, 0.02, 0.04, 0.0, 0.005, 0.01], abs=1e-12),
            ),
        },
    ),
)
