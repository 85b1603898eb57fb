"""One diagram: a kind of error by a cost."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from stretch_bt.accuracy.job import Panel
from stretch_bt.accuracy.picture.labels import Label, LabelBox, placed
from stretch_bt.accuracy.picture.marks import bar, open_mark, point
from stretch_bt.accuracy.points import Kind, Row
from stretch_bt.accuracy.summary import MANY, Spread, Summary
from stretch_bt.draw.axes import Frame, columns, rows, words
from stretch_bt.draw.scale import Logarithmic, decades

__all__ = ["HEIGHT", "WIDTH", "panel"]

WIDTH, HEIGHT = 660, 470
_ROOM = LabelBox(62.0, 58.0, WIDTH - 28.0, HEIGHT - 48.0)
_FAILED = 44.0  # y of the marks of cases without an answer


class _Dot(NamedTuple):
    """A setting, as it is drawn: cost in the axis' unit, errors in the shown unit."""

    summary: Summary
    cost: float
    errors: Spread

    @property
    def series(self) -> str:
        return self.summary.setting.series


def panel(which: Panel, kind: Kind, found: Sequence[Summary], colors: Mapping[str, str], peers: frozenset[str]) -> str:
    """Return a diagram of some settings; empty where none has an error and a cost.

    The dashed line is the median of the reference's own error, below which differences mean nothing; what is below a
    tenth of it stands at the lower edge.
    """
    dots = [dot for s in found if not s.is_reference and (dot := _dot(which, kind, s)) is not None]
    if not dots:
        return ""
    lines = _lines(which, kind, found)
    low = max((value for value, _, _ in lines), default=0.0) / 10
    errors = [max(e, low) for dot in dots for e in (dot.errors.median, dot.errors.end)] + [
        value for value, _, _ in lines
    ]
    failed = [(s, cost) for s in found if (cost := _failed_cost(which, s)) is not None]
    across = Logarithmic(decades([*(dot.cost for dot in dots), *(cost for _, cost in failed)]), _ROOM.left, _ROOM.right)
    up = Logarithmic(decades([e for e in errors if e > 0] or [1.0]), _ROOM.bottom, _ROOM.top)
    frame = Frame(across, up)
    floor, taken = _floors(frame, lines)
    by_cost = sorted(dots, key=lambda dot: dot.cost)
    series = {name: [dot for dot in by_cost if dot.series == name] for name in colors}
    drawn = "".join(_series(frame, group, colors[name], name in peers) for name, group in series.items() if group)
    return (
        _axes(which, kind, across, up)
        + floor
        + drawn
        + "".join(open_mark(frame.x(cost), _FAILED, colors[s.setting.series]) for s, cost in failed)
        + _labels(frame, peers, colors, dots, failed, taken)
    )


def _dot(which: Panel, kind: Kind, summary: Summary) -> _Dot | None:
    errors, costs = summary.errors(which.kind), summary.costs(which.axis.of, which.kind)
    if errors is None or costs is None or costs.median <= 0:
        return None
    return _Dot(summary, costs.median, errors.times(kind.scale))


def _lines(which: Panel, kind: Kind, found: Sequence[Summary]) -> list[tuple[float, str, str]]:
    """Return the errors at which lines are drawn, with their class and their name."""
    held = [s for s in found if not s.is_reference]
    own = [r.reference_error for s in held for r in s.answers if r.error_kind == which.kind and r.reference_error]
    lines = [(float(np.median(own)) * kind.scale, "f", "the reference's own error")] if own else []
    for summary in (s for s in found if s.is_reference and not _states_own(s)):
        bound = summary.errors(which.kind)
        if bound is not None:
            lines.append((bound.median * kind.scale, "b", str(summary.setting)))
    return lines


def _states_own(summary: Summary) -> bool:
    return any(row.reference_error is not None for row in summary.answers)


def _failed_cost(which: Panel, summary: Summary) -> float | None:
    """Return the cost at which the cases of a setting without an answer are drawn: their median, None where none has a cost."""
    if summary.is_reference:
        return None
    found: list[float] = [cost for row in _unanswered(which, summary) if (cost := which.axis.of(row))]
    return float(np.median(found)) if found else None


def _unanswered(which: Panel, summary: Summary) -> list[Row]:
    return [row for row in summary.unanswered if row.error_kind == which.kind]


def _axes(which: Panel, kind: Kind, across: Logarithmic, up: Logarithmic) -> str:
    middle = (_ROOM.left + _ROOM.right) / 2
    unit = "" if kind.unit == "1" else f", {kind.unit}"
    title = which.title or f"error of the {which.kind.replace('_', ' ')}"
    below = [(across.place(mark), f"{mark:g}") for mark in across.marks]
    beside = [(up.place(mark), f"{mark:g}") for mark in up.marks]
    return (
        f'<text class="t" x="14" y="20">{html.escape(title + unit)}</text>'
        + words(middle, _ROOM.bottom + 36, which.axis.name, "m")
        + columns(below, _ROOM.top, _ROOM.bottom, _ROOM.bottom + 16, "m")
        + rows(beside, _ROOM.left, _ROOM.right, "e")
    )


def _floors(frame: Frame, lines: Sequence[tuple[float, str, str]]) -> tuple[str, list[LabelBox]]:
    """Return the dashed lines with their names, and the room that these take."""
    parts, taken = [], []
    for value, style, name in lines:
        y = frame.y(value)
        parts.append(f'<path class="{style}" d="M{_ROOM.left:g} {y:.1f}H{_ROOM.right:g}"/>')
        parts.append(words(_ROOM.right - 2, y - 4, name, "l e"))
        taken += [
            LabelBox(_ROOM.right - 6.1 * len(name), y - 14, _ROOM.right, y),
            LabelBox(_ROOM.left, y - 1, _ROOM.right, y + 1),
        ]
    return "".join(parts), taken


def _series(frame: Frame, dots: Sequence[_Dot], color: str, peer: bool) -> str:
    places = [(frame.x(dot.cost), frame.y(dot.errors.median)) for dot in dots]
    steps = sum(any(c.isdigit() for c in dot.summary.setting.variant) for dot in dots)
    line = f'<path d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in places)}" stroke="{color}" opacity="0.45"/>'
    parts = [line] if 2 * steps >= len(dots) > 1 else []  # only steps of a number are joined by a line
    for (x, y), dot in zip(places, dots, strict=True):
        errors = dot.errors
        if errors.count > 1:
            parts.append(bar(x, y, frame.y(errors.end), color, many=errors.count >= MANY))
        title = f"{dot.summary.setting}: {errors.median:.3g}, {errors.end_name} {errors.end:.3g}, at {dot.cost:.3g}"
        parts.append(point(x, y, color, peer=peer, default=dot.summary.default, title=title))
    return "".join(parts)


def _labels(
    frame: Frame,
    peers: frozenset[str],
    colors: Mapping[str, str],
    dots: Sequence[_Dot],
    failed: Sequence[tuple[Summary, float]],
    taken: Sequence[LabelBox],
) -> str:
    labels, boxes = [], [*taken]
    for dot in dots:
        x, y, end = frame.x(dot.cost), frame.y(dot.errors.median), frame.y(dot.errors.end)
        setting = dot.summary.setting
        alone = dot.series in peers and sum(other.series == dot.series for other in dots) == 1
        words = str(setting) if alone else setting.variant or dot.series
        words = f"default: {words}" if dot.summary.default else words
        labels.append(Label(x, y, words, colors[dot.series], dot.summary.default))
        boxes += [LabelBox(x - 6, y - 6, x + 6, y + 6), LabelBox(x - 4, end, x + 4, y)]
    for summary, cost in failed:
        x, count = frame.x(cost), len({(r.case, r.seed) for r in summary.unanswered})
        setting = summary.setting
        words = f"{setting.variant or setting.series}: {count} of {count + summary.answered}"
        labels.append(Label(x, _FAILED, words, colors[summary.setting.series]))
        boxes.append(LabelBox(x - 6, _FAILED - 6, x + 6, _FAILED + 6))
    return placed(labels, boxes, LabelBox(_ROOM.left - 50, 26.0, _ROOM.right + 12, _ROOM.bottom + 2))
