"""A cookie: the dough before, while and after, its height and roundness over time, and both outlines."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from stretch_bt.plain_numbers import is_number
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.chart import Line, Mark, chart
from stretch_bt.runtime.report.panels.keys import Key
from stretch_bt.runtime.report.text import escape, number, seconds, section, table
from stretch_bt.runtime.sketches import SKETCHES

__all__ = ["panel"]

TREES = ("form_cookie", "form_cookie_fast")
LINE, BEFORE = Key("line", TREES), Key("before", TREES)
ROUND = (Key("residual", TREES[1:]), Key("spread", TREES), Key("width", TREES[1:]))
SHAPES, SENSED = "#1c2430", "#c0392b"
COLORS = {"height": "#2563a8", "spread": "#b3541e", "residual": "#6a4c93", "width": "#2f7d4f"}
CIRCULARITIES = ("circularity_true", "low_pass_true", "pixel_chain_true", "circularity_sensed", "pixel_chain")
NOTE = (
    "the dough as the scene has it; of a lump the outline is the one that it would be pressed to. The sensed outline is a level "
    "line of the slack membrane, as a controller has it: it runs over the shoulder of the disc, and is smaller"
)


def panel(record: RecordReader) -> str:
    """Return the panel of a run that sketched what it shaped; nothing where there is no sketch."""
    path = record.folder / SKETCHES
    if not path.exists():
        return ""
    sketches: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    parts = [_sides(sketches), _outlines(sketches, record), *_times(record)]
    return section("Cookie", f'<div class="grid">{"".join(parts)}</div>{_circularities(record)}', NOTE)


def _sides(sketches: Sequence[dict[str, Any]]) -> str:
    """Draw it from the side before, while and after, beside each other."""
    chosen = [sketches[0], sketches[len(sketches) // 2], sketches[-1]]
    lines, start = [], 0.0
    for row, name in zip(chosen, ("before", "while", "after"), strict=True):
        left, right = min(x for x, _ in row["side"]), max(x for x, _ in row["side"])
        shifted = [(1e3 * (x - left) + start, 1e3 * z) for x, z in _closed(row["side"])]
        lines.append(Line(shifted, SHAPES, f"{name}, {seconds(float(row['time']))} s"))
        start += 1e3 * (right - left) + 8
    return chart("from the side", "mm", "mm", lines, [])


def _outlines(sketches: Sequence[dict[str, Any]], record: RecordReader) -> str:
    """Draw the true outline at the end and, about its middle, the sensed one."""
    lines = [Line(_placed(sketches[-1]["outline"]), SHAPES, "true")]
    sensed = _written(record, LINE, _is_line)
    if sensed:
        flat = sensed[-1][1]
        lines.append(Line(_placed([(x, -y) for x, y in zip(flat[::2], flat[1::2], strict=True)]), SENSED, "sensed"))
    return chart("outlines from above", "mm", "mm", lines, [])


def _placed(line: Iterable[Sequence[float]]) -> list[tuple[float, float]]:
    """Return a closed line in mm about its middle."""
    points = [(float(x), float(y)) for x, y in line]
    x, y = (sum(p[k] for p in points) / len(points) for k in (0, 1))
    return [(1e3 * (a - x), 1e3 * (b - y)) for a, b in _closed(points)]


def _closed(line: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in (*line, line[0])]


def _times(record: RecordReader) -> list[str]:
    """Draw the heights and the deviations from a ball over time."""
    found = []
    heights = _written(record, BEFORE)
    if heights:
        marks = [Mark(t, 1e3 * h, COLORS["height"]) for t, h in heights]
        found.append(chart("height of the top while it rolls", "time, s", "mm", [], marks))
    told = {key.name: _written(record, key, known=True) for key in ROUND}
    if told["spread"]:
        scale = 1.0 if told["width"] else 1e3
        lines = [
            Line([(t, scale * v) for t, v in rows], COLORS[name], name)
            for name, rows in told.items()
            if rows and name != "width"
        ]
        unit = "over the radius" if told["width"] else "mm"
        found.append(chart("how far from a ball, by the last looks", "time, s", unit, lines, []))
    return found


def _written(
    record: RecordReader, key: Key, fits: Callable[[Any], bool] = is_number, known: bool = False
) -> list[tuple[float, Any]]:
    """Return the times, s, at which a key was written, and its values, those that fit: any task may have a key of this name.

    With `known`, those alone that nodes know: before there are two looks they tell a large value, and as large a deviation.
    """
    events = [e for e in record.events if key.wrote(e) and fits(e["value"])]
    return [(float(e["time"]), e["value"]) for e in events if not (known and e.get("sd") == e["value"])]


def _is_line(value: Any) -> bool:
    """Return whether a value is a list of x, y, x, y and so on."""
    return isinstance(value, list) and len(value) % 2 == 0 < len(value) and all(map(is_number, value))


def _circularities(record: RecordReader) -> str:
    outputs = (record.result or {}).get("outputs") or {}
    rows = [[escape(name), escape(number(outputs[name]["value"]))] for name in CIRCULARITIES if name in outputs]
    return table(("circularity", ""), rows, numeric=(1,)) if rows else ""
