"""What the report shows, gathered from a record in one pass: series, intervals of status, frames, last readings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.frames import DepthFrame, Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.plain_numbers import is_number
from stretch_bt.runtime.record import RecordReader
from stretch_bt.units import KINDS, Kind

__all__ = ["Frames", "History", "Series", "Span", "gather"]


@dataclass(slots=True)
class Series:
    """A quantity over time: points are (time in s, value, sd or None), SI."""

    name: str
    kind: Kind | None = None
    points: list[tuple[float, float, float | None]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Span:
    """A node was in `status` from `start` to `end`, s; a status that ends a node has no length."""

    status: str
    start: float
    end: float
    reason: str


@dataclass(slots=True)
class Frames:
    """The first and last frame of a camera, with their run times, s."""

    first: tuple[float, DepthFrame]
    last: tuple[float, DepthFrame]


@dataclass(slots=True)
class History:
    """Everything over time that the page shows."""

    keys: dict[str, Series] = field(default_factory=dict)
    readings: dict[str, Series] = field(default_factory=dict)
    spans: dict[str, list[Span]] = field(default_factory=dict)
    frames: dict[str, Frames] = field(default_factory=dict)
    last: list[tuple[str, str, Reading[Any]]] = field(default_factory=list)
    start: float = 0.0
    end: float = 0.0


def gather(record: RecordReader) -> History:
    """Return the history of a run."""
    history = History()
    times = [time for _, time in record.ticks] + [_time(event) for event in record.events]
    history.start, history.end = min(times, default=0.0), max(times, default=0.0)
    for event in record.events:
        if event["type"] == "write":
            _take_write(history.keys, event, record.header)
    history.spans = _spans(record.events, history.end)
    ticks = dict(record.ticks)
    for tick, time in ticks.items():
        for device, name, reading in record.readings(tick, frames=False):
            _take_reading(history.readings, f"{device}.{name}", time, reading.value)
    history.last = next((found for tick in reversed(ticks) if (found := record.readings(tick))), [])
    for device, seen in record.framed().items():
        within = [tick for tick in seen if tick in ticks]
        if within:
            first, last = (
                (ticks[k], _frame(record, k, device, which)) for k, which in ((within[0], 0), (within[-1], -1))
            )
            history.frames[device] = Frames(first, last)
    return history


def _frame(record: RecordReader, tick: int, device: str, which: int) -> DepthFrame:
    """Return one of the frames of a camera in a tick."""
    found = [r.value for d, _, r in record.readings(tick) if d == device and isinstance(r.value, DepthFrame)]
    return found[which]


def _time(event: dict[str, Any]) -> float:
    return float(event["time"])


def _take_write(keys: dict[str, Series], event: dict[str, Any], header: dict[str, Any]) -> None:
    kinds = header.get("keys")
    named = str(kinds.get(event["key"])) if isinstance(kinds, dict) else ""
    for name, value, sd in _scalars(event["key"], event["value"], event.get("sd")):
        kind = KINDS.get(named) if name == event["key"] else None
        keys.setdefault(name, Series(name, kind)).points.append((_time(event), value, sd))


def _scalars(name: str, value: Any, sd: Any) -> Iterator[tuple[str, float, float | None]]:
    """Yield a number, or the numbers among the fields of an object, each with its sd."""
    if _is_number(value):
        yield name, float(value), float(sd) if _is_number(sd) else None
    elif isinstance(value, dict):
        for field_name, item in value.items():
            is_sd = field_name.endswith("_sd") and field_name.removesuffix("_sd") in value
            if _is_number(item) and not is_sd:
                yield from _scalars(f"{name}.{field_name}", item, value.get(f"{field_name}_sd"))


def _is_number(value: Any) -> bool:
    """Return whether a value can be drawn over the time; a truth is drawn as 0 or 1."""
    return isinstance(value, bool) or is_number(value)


def _spans(events: list[dict[str, Any]], end: float) -> dict[str, list[Span]]:
    changes: dict[str, list[dict[str, Any]]] = {}
    for event in events:
        if event["type"] == "status":
            changes.setdefault(event["path"], []).append(event)
    return {path: _path_spans(found, end) for path, found in changes.items()}


def _path_spans(changes: list[dict[str, Any]], end: float) -> list[Span]:
    ends = [*map(_time, changes[1:]), end]
    return [
        Span(
            change["status"],
            _time(change),
            until if change["status"] == "RUNNING" else _time(change),
            change.get("reason", ""),
        )
        for change, until in zip(changes, ends, strict=True)
    ]


def _take_reading(series: dict[str, Series], name: str, time: float, value: Any) -> None:
    if isinstance(value, Pose):
        one = Series(f"{name}.height", KINDS["Length"]), value.height
    elif isinstance(value, Wrench):
        one = Series(f"{name}.force", KINDS["Force"]), value.magnitude
    elif _is_number(value):
        one = Series(name, KINDS["Length"] if name.endswith(".opening") else None), float(value)
    else:
        return
    empty, number = one
    if math.isfinite(number):
        series.setdefault(empty.name, empty).points.append((time, number, None))
