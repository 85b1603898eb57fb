"""The map of presses: an object that moved, stands apart, goes on to a clamp, hangs over, or is not there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.hardcases.domains.perception.sheets import MM, box, dome, mapped, pressed
from stretch_bt.hardcases.expect import Check, Range, Refusal, Value
from stretch_bt.hardcases.hard import group
from stretch_bt.perception.clouds.coverage import coverage, hidden
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import Relief, add_view

ACROSS = (0, 0, np.pi / 2)
MOVED = Refusal(IllConditioned, "the object moved or gave way")
REACH: dict[str, Any] = {"depth": 10 * MM, "length": 100 * MM, "width": 90 * MM}


def _after(**moved: Any) -> Callable[[], Relief]:
    """Return a call that adds a press of a box that is no more as it was."""
    return lambda: add_view(pressed(lambda x, y: box(x, y, **moved), yaw=0.1), mapped(box, (0, 0, 0), ACROSS))


def _pair(x: Any, y: Any) -> Any:
    left, right = (dome(x, y, (9 * MM,) * 2, 15 * MM, (at, 0.0)) for at in (-20 * MM, 20 * MM))
    return np.maximum(left, right)


def _long(x: Any, y: Any) -> Any:
    return box(x, y, half=(20 * MM, 70 * MM)) - 0.5 * MM


def _nothing(x: Any, y: Any) -> Any:
    return 0.0 * x


def _carved_only(relief: Relief) -> bool:
    return (relief.felt_area, coverage(relief), relief.summit, relief.pieces) == (0.0, 0.0, None, 0)


def _clear_of_the_clamps(relief: Relief) -> bool:
    return bool(np.abs(relief.place(np.argwhere(relief.felt))[:, 1]).max() < 45 * MM)


def _only_its_upper_side(relief: Relief) -> bool:
    """Whether of a plate on a stem the stem is neither felt nor looked for."""
    felt = np.abs(relief.height[relief.felt] - 30 * MM).max() < 3 * MM
    return bool(felt and hidden(relief).height[hidden(relief).cells].min(initial=1.0) > 20 * MM)


def _tried() -> tuple[float, float]:
    """Return how far from a press that showed nothing the next one goes, m, and its expected gain over the first one's."""
    ground = partial(box, half=(65 * MM, 20 * MM))
    relief = mapped(ground, (0, 0, 0), height=12 * MM)
    first = next_view(relief, **{**REACH, "depth": 18 * MM})
    assert first is not None
    place = first.x, first.y, first.yaw
    then = next_view(relief, tried=[place] * 3, **{**REACH, "depth": 18 * MM})
    assert then is not None
    return float(np.hypot(then.x - first.x, then.y - first.y)), then.gain / first.gain


def _missed() -> float:
    """Return the gain of the next press after one that was to show a side and did not, over its gain where that one is only left out."""
    relief = mapped(box, (0, 0, 0), height=22 * MM)
    first = next_view(relief, **REACH)
    assert first is not None
    place = first.x, first.y, first.yaw
    pressed_there = next_view(replace(relief, poses=(*relief.poses, place)), **REACH)
    only_left_out = next_view(relief, tried=[place], **REACH)
    assert pressed_there is not None
    assert only_left_out is not None
    return pressed_there.gain / only_left_out.gain


CASES = (
    *group(
        "presses are put together on the assumption that the object stayed where it was",
        {
            "the object sank by 3 mm": (_after(top=27 * MM), MOVED),
            "the object rose by 3 mm": (_after(top=33 * MM), MOVED),
            "the object went 9 mm across": (_after(at=(9 * MM, 0.0)), MOVED),
            "the object went 9 mm along": (_after(at=(0.0, -9 * MM)), MOVED),
            "another, smaller object": (_after(half=(12 * MM, 12 * MM)), MOVED),
            "the object stayed": (lambda: _after()().views, Value(3)),
        },
        prefix="map, ",
    ),
    *group(
        "the felt surface is in two parts, goes on under a clamp, or is only the upper side",
        {
            "two objects": (lambda: mapped(_pair, (0, 0, 0), ACROSS, height=4 * MM).pieces, Value(2)),
            "contact at the clamp is told": (lambda: pressed(_long, height=26 * MM).cut, Value(True)),
            "contact short of the clamps": (lambda: pressed(box).cut, Value(False)),
            "contact at the clamp is not believed": (
                lambda: add_view(pressed(_long, height=26 * MM)),
                Check("nothing is felt within 5 mm of a clamp", _clear_of_the_clamps),
            ),
            "an overhang": (
                lambda: mapped(box, (0, 0, 0), ACROSS),
                Check("only the upper side is felt and looked for", _only_its_upper_side),
            ),
        },
        prefix="map, ",
    ),
    *group(
        "nothing was felt, or the rest cannot be reached",
        {
            "no contact": (
                lambda: mapped(_nothing, (0, 0, 0)),
                Check("nothing felt, no piece, no summit", _carved_only),
            ),
            "no contact to plan from": (
                lambda: next_view(mapped(_nothing, (0, 0, 0)), **REACH),
                Refusal(NoContact, "nothing was felt yet"),
            ),
            "presses that showed nothing": (
                _tried,
                Check("another place, which shows less", lambda f: f[0] > 5 * MM and 0 < f[1] < 1),
            ),
            "a press that was to show a side and did not": (_missed, Range(0.5, 0.95)),
            "no place in reach": (
                lambda: next_view(mapped(box, (0, 0, 0)), x=(0.4, 0.5), y=(0.4, 0.5), **REACH),
                Value(None),
            ),
        },
        prefix="map, ",
    ),
)
