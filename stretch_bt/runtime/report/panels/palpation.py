"""Palpation: the presses over the force model's curves, and the force on the object against how far it gave way."""

from __future__ import annotations

import math
from itertools import takewhile
from typing import Any

from stretch_bt.errors import InvalidInput, NoAnswer
from stretch_bt.model.force.force_model import ForceModel
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.chart import Line, Mark, chart
from stretch_bt.runtime.report.panels.keys import Key, finite
from stretch_bt.runtime.report.panels.looks import TREES, Look, read_looks
from stretch_bt.runtime.report.panels.used_model import used_model
from stretch_bt.runtime.report.text import escape, number, seconds, section
from stretch_bt.units import parse_unit

__all__ = ["panel"]

STIFFNESS = Key("main/stiffness_at_drop", TREES)
POINTS = 40  # of a curve
LABELLED = 12  # presses beside each of which its number stands
BEYOND = 1.15  # times the deepest and the hardest press, to where curves are drawn
PATH, OBJECT, TRUTH = "#8a94a3", "#5b6675", "#1c2430"
NOTE = "a mark is a look at a press: depth as seen, force and drop by what was fitted so far, ± one sd; presses are numbered in order"


def panel(record: RecordReader) -> str:
    """Return the panel of a task whose keys have the names of the keys of `palpate_stiffness`; nothing before its first look."""
    looks = read_looks(record.events)
    if not looks:
        return ""
    curves, why = _curves(record, looks)
    note = f"{NOTE}<br>{escape(why)}" if why else NOTE
    return section("Palpation", f'<div class="grid">{_path(looks, curves)}{_object(record, looks)}</div>', note)


def _path(looks: list[Look], curves: list[Line]) -> str:
    """Draw force against the depth of the membrane: a curve for each stretch, and the way over them."""
    colors, labels = _colors(looks), _numbers(looks)
    way = Line([(1e3 * look.depth, look.force) for look in looks], PATH, dashed=True)
    marks = [
        Mark(1e3 * k.depth, k.force, colors[k.stretch], 1e3 * k.depth_sd, k.force_sd, label, _title(k))
        for k, label in zip(looks, labels, strict=True)
    ]
    shown = curves or [Line([], color, _name(stretch)) for stretch, color in colors.items()]
    return chart("path of the presses, by stretch", "depth of the membrane, mm", "force, N", [*shown, way], marks)


def _object(record: RecordReader, looks: list[Look]) -> str:
    """Draw the force on the object against its drop, the curve that was fitted, and what the scene knows of the last press."""
    colors, labels = _colors(looks), _numbers(looks)
    marks = [
        Mark(1e3 * k.drop, k.force, colors[k.stretch], 1e3 * k.drop_sd, k.force_sd, label, _title(k))
        for k, label in zip(looks, labels, strict=True)
    ]
    truth, known = _truth(record)
    lines = [*_fitted(record, looks[-1]), *known]
    return chart("the object", "drop of its top, mm", "force on it, N", lines, [*marks, *truth])


def _truth(record: RecordReader) -> tuple[list[Mark], list[Line]]:
    """Return a ring where the scene knows the last press to be, and its line in the legend."""
    truth = (record.result or {}).get("truth") or {}
    drop, force = (_si(truth.get(name) or {}) for name in ("deflection", "force"))
    if not math.isfinite(drop * force):
        return [], []
    return [Mark(1e3 * drop, force, TRUTH, hollow=True)], [Line([], TRUTH, "ring: the last press, by the scene")]


def _si(output: dict[str, Any]) -> float:
    """Return the value of an output, in SI; NaN where it is no number."""
    value = output.get("value")
    try:
        return float(value * parse_unit(str(output.get("unit")))[0]) if isinstance(value, int | float) else math.nan
    except InvalidInput:
        return math.nan


def _fitted(record: RecordReader, last: Look) -> list[Line]:
    """Return the curve that was fitted last, from its two points that the record holds: its force grows as a power of the drop."""
    params = record.header.get("params") or {}
    drop = params.get("wanted_deflection", params.get("drop"))  # the latter in older records
    stiffness = finite(STIFFNESS.last(record.events))
    if not isinstance(drop, float) or stiffness is None or not min(drop, stiffness, last.drop, last.force) > 0:
        return []
    apart = math.log(drop / last.drop)
    if abs(apart) < 1e-6:
        return []
    power = math.log(stiffness * drop / last.force) / apart
    end = BEYOND * max(drop, last.drop)
    drops = [end * k / POINTS for k in range(POINTS + 1)]
    return [Line([(1e3 * d, last.force * (d / last.drop) ** power) for d in drops], OBJECT, "fitted to all looks")]


def _curves(record: RecordReader, looks: list[Look]) -> tuple[list[Line], str]:
    """Return the model's curve for each stretch at the felt radius, or none; and a remark on them."""
    model, why = used_model(record)
    if model is None:
        return [], why
    try:
        return [_curve(model, looks, stretch, color) for stretch, color in _colors(looks).items()], why
    except (InvalidInput, NoAnswer) as error:
        return [], f"without the curves of the force model: {error}"


def _curve(model: ForceModel, looks: list[Look], stretch: float, color: str) -> Line:
    hardest = BEYOND * max(look.force + look.force_sd for look in looks)
    low, high = model.range.depth
    deepest = min(BEYOND * max(look.depth for look in looks), high)
    depths = [low + max(deepest - low, 0.0) * k / POINTS for k in range(POINTS + 1)]
    told = ((1e3 * depth, model.predict(looks[-1].radius, stretch, depth)[0]) for depth in depths)
    return Line([*takewhile(lambda point: point[1] <= hardest, told)], color, _name(stretch))


def _numbers(looks: list[Look]) -> list[str]:
    """Return the number of the press beside its first look, of many presses of the first and the last alone."""
    before = [None, *looks]
    new = [last is None or not look.same_press(last) for last, look in zip(before, looks, strict=False)]
    numbers, count = [sum(new[: k + 1]) for k in range(len(looks))], sum(new)
    shown = {1, count} if count > LABELLED else range(1, count + 1)
    return [str(n) if first and n in shown else "" for n, first in zip(numbers, new, strict=True)]


def _colors(looks: list[Look]) -> dict[float, str]:
    """Return a colour for each stretch, from blue to red."""
    stretches = sorted({look.stretch for look in looks})
    parts = [k / max(len(stretches) - 1, 1) for k in range(len(stretches))]
    return {x: f"hsl({215 - 215 * part:.0f} 65% 45%)" for x, part in zip(stretches, parts, strict=True)}


def _name(stretch: float) -> str:
    return f"{number(1e3 * stretch)} mm"


def _title(look: Look) -> str:
    return (
        f"{seconds(look.time)} s, stretch {_name(look.stretch)}\ndepth {number(1e3 * look.depth)} mm, force {number(look.force)} N, "
        f"drop {number(1e3 * look.drop)} mm"
    )
