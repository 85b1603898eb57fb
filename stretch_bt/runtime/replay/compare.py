"""Comparing two logs: the decisions, and the last digits, which another processor changes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np

from stretch_bt.plain_numbers import is_number
from stretch_bt.runtime.record.places import Places
from stretch_bt.runtime.record.plain import plain

__all__ = ["ANGLES", "RELATIVE", "Comparison", "compare"]

#: largest difference of a number from the recorded one: as a part of itself, and of its standard deviation
RELATIVE, OF_SD = 1e-6, 1e-3
#: SI; a smaller number is compared as if it were so large: next to nothing has no last digits
TINY = 1e-9
#: fields that are angles, rad, which are compared as if they were a radian: 0 is a direction like any other
ANGLES = frozenset({"angle", "heading", "rotation", "yaw"})
#: fields of text for people: numbers in them are shown with few digits, and the last one may be rounded either way
_TOLD = ("reason", "why")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", re.ASCII)
_PLACES = Places()  # older records hold them
Event = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Comparison:
    """How far two logs agree.

    Attributes
    ----------
    identical : bool
        They are the same to the last digit.
    same : bool
        Every status, command and motion is the same, and every number as good as the same.
    largest : float
        The largest difference of a number, as a part of the number or of 1000 standard deviations; of what was compared.
    first : pair of events or None
        The first that are not the same, or else the first that are not identical; None in place of one that is not there.
    """

    identical: bool
    same: bool
    largest: float
    first: tuple[Event | None, Event | None] | None


def compare(recorded: Sequence[Event], replayed: Sequence[Event]) -> Comparison:
    """Compare two logs event by event, up to the first that decides otherwise."""
    largest, first = 0.0, None
    for old, new in zip_longest(recorded, replayed):
        if old == new and _text(old) == _text(new):  # 1, 1.0 and true are equal, and are written differently
            continue
        first = first or (old, new)
        if old is not None and new is not None and old.get("type") == "write" and "sd" in new.keys() - old.keys():
            new = {name: value for name, value in new.items() if name != "sd"}  # older versions stated none there
        difference = math.inf if old is None or new is None else max(_differences(old, new), default=0.0)
        if difference < math.inf:
            largest = max(largest, difference)
        if difference > RELATIVE:
            return Comparison(False, False, largest, (old, new))
    return Comparison(first is None, True, largest, first)


def _text(event: Event | None) -> str:
    return json.dumps(event, sort_keys=True)


def _differences(old: Any, new: Any, sd: Any = None, scale: float = 0.0) -> Iterator[float]:
    """Yield the differences of all numbers; an infinite one where anything else differs.

    `sd` is the standard deviation, `scale` the size of the vector that a number is a component of.
    """
    if isinstance(old, bool) != isinstance(new, bool):
        yield math.inf
    elif is_number(old) and is_number(new) and not (isinstance(old, int) and isinstance(new, int)):
        yield _difference(old, new, sd, scale)
    elif isinstance(old, Mapping) and isinstance(new, Mapping):
        yield from _of_mappings(old, new)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        size = max((scale, *(abs(v) for v in old if is_number(v))))
        sds = sd if isinstance(sd, list) and len(sd) == len(old) else [sd] * len(old)
        for a, b, s in zip(old, new, sds, strict=True):
            yield from _differences(a, b, s, size)
    elif old != new and _PLACES.left_out(old) != _PLACES.left_out(new):
        yield math.inf


def _of_mappings(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[float]:
    if "sha256" in old and "sha256" in new:
        yield from _of_arrays(old, new)
        return
    if "middle" in old and "middle" not in new:
        new = _with_middle(new)
    if old.keys() != new.keys():
        yield math.inf
        return
    for name, value in old.items():
        if name in _TOLD:
            yield from _of_texts(str(value), str(new[name]))
            continue
        sd = old.get(f"{name}_sd", old.get("sd") if name == "value" else None)
        yield from _differences(value, new[name], sd, 1.0 if name in ANGLES else 0.0)


def _with_middle(new: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a Solid as older records hold it: with the middle of its top as one array for the three coordinates."""
    place = [new.get(name) for name in ("x", "y", "z")]
    if not all(map(is_number, place)):
        return new
    return {name: value for name, value in new.items() if name not in ("x", "y", "z")} | {
        "middle": plain(np.array(place, float))
    }


def _of_arrays(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[float]:
    """Yield how far the sums that stand for two arrays differ, measured against the largest number in them."""
    if any(old.get(name) != new.get(name) for name in ("shape", "dtype", "finite")) or "largest" not in old:
        yield math.inf if old != new else 0.0
        return
    for name in ("largest", "mean", "weighted"):
        if name in old:  # older records have no weighted mean
            yield from _differences(old[name], new.get(name), None, abs(old["largest"]))


def _difference(old: float, new: float, sd: Any, scale: float) -> float:
    if old == new:
        return 0.0
    spread = abs(sd) * RELATIVE**-1 * OF_SD if is_number(sd) else 0.0
    return abs(old - new) / max(abs(old), scale, spread, TINY)


def _of_texts(old: str, new: str) -> Iterator[float]:
    """Yield how far the numbers in two texts differ beyond their rounding; an infinite one where the words differ."""
    old, new = _PLACES.without(old), _PLACES.without(new)
    if _NUMBER.split(old) != _NUMBER.split(new):
        yield math.inf
        return
    for a, b in zip(_NUMBER.findall(old), _NUMBER.findall(new), strict=True):
        if a != b:
            yield _beyond_rounding(a, b)


def _beyond_rounding(old: str, new: str) -> float:
    """Return how far two shown numbers differ by more than one unit of the last place shown; counts have none."""
    a, b, place = float(old), float(new), min(_place(old), _place(new))
    beyond = abs(a - b) - 1.001 * place  # 0.3 - 0.2 is a little more than 0.1
    counts = all(shown.lstrip("+-").isdecimal() for shown in (old, new))
    if counts or not math.isfinite(beyond):
        return math.inf
    return max(0.0, beyond) / max(abs(a), TINY)


def _place(shown: str) -> float:
    """Return one unit of the last place of a shown number."""
    digits, _, exponent = shown.partition("e")
    return float(f"1e-{len(digits.partition('.')[2])}") * float(f"1e{exponent or 0}")
