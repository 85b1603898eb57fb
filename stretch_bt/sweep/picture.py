"""Pictures of a sweep as SVG: of each output a line for each group, with its values, their median, and the truth."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stretch_bt.draw.axes import columns, words
from stretch_bt.draw.scale import Linear
from stretch_bt.runtime.report.text import escape, number
from stretch_bt.sweep.summary import Output, Summary, SweepGroup

__all__ = ["draw", "write_pictures"]

WIDTH, LEFT, RIGHT, TOP, LINE, BOTTOM = 960, 330, 24, 40, 26, 44
#: groups that one picture shows, and values of a group: more would be a blot
MOST_GROUPS, MOST_DOTS = 100, 400
_STYLE = (
    "text{font:12px sans-serif;fill:#333}.t{font-weight:bold}.m{text-anchor:middle}.e{text-anchor:end}"
    ".g{stroke:#e3e3e3}.d{fill:#0b6e99;fill-opacity:.45}.v{stroke:#0b6e99;stroke-width:2}.k{stroke:#d1495b;stroke-width:2}"
)
_LEGEND = "a dot is an item that came to SUCCESS, | their median, | red the mean truth"


def write_pictures(folder: Path, summary: Summary) -> list[str]:
    """Write a picture of each output into a folder, and return the names of the files."""
    groups = list(summary.groups.values())
    names = dict.fromkeys(name for group in groups for name in group.outputs)
    written = []
    for name in names:
        shown = [(group, group.outputs[name]) for group in groups if name in group.outputs]
        file = f"{re.sub(r'[^A-Za-z0-9_-]', '_', name)}.svg"
        (folder / file).write_text(draw(name, shown), encoding="utf-8")
        written.append(file)
    return written


def _scale(outputs: Sequence[Output]) -> Linear:
    """Return a scale that shows all values and truths."""
    each = np.concatenate([np.asarray(v, np.float64) for o in outputs for v in (o.values, o.truths)])
    known = each[np.isfinite(each)]
    low, high = float(known.min()), float(known.max())
    margin = 0.04 * (high - low) or 0.05 * abs(high) or 1.0
    return Linear(low - margin, high + margin, LEFT, WIDTH - RIGHT)


def draw(name: str, shown: Sequence[tuple[SweepGroup, Output]]) -> str:
    """Return the picture of one output of some groups, the first hundred of them."""
    left_out, shown = max(len(shown) - MOST_GROUPS, 0), shown[:MOST_GROUPS]
    scale = _scale([output for _, output in shown])
    bottom = TOP + LINE * len(shown)
    axis = columns([(scale.place(v), number(v, 5)) for v in scale.ticks(8)], TOP, bottom, bottom + 18, "m")
    lines = [_line(scale, TOP + LINE * (k + 0.5), group, output) for k, (group, output) in enumerate(shown)]
    unit = shown[0][1].unit
    title = f"{name}, {unit}" if unit else name
    more = f"; {left_out} more groups are in summary.json" if left_out else ""
    body = words(12, 22, title, "t") + words(LEFT, 22, _LEGEND + more) + axis + "".join(lines)
    height = bottom + BOTTOM
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}">'
    return f'{head}<style>{_STYLE}</style><rect width="{WIDTH}" height="{height}" fill="#fff"/>{body}</svg>\n'


def _line(scale: Linear, y: float, group: SweepGroup, output: Output) -> str:
    values = np.sort(np.asarray(output.values, np.float64))
    step = math.ceil(len(values) / MOST_DOTS)
    dots = "".join(f'<circle class="d" cx="{scale.place(v):.1f}" cy="{y:.1f}" r="3"/>' for v in values[::step])
    truths = np.asarray(output.truths, np.float64)
    known = truths[np.isfinite(truths)]
    median = _tick(scale, "v", float(np.median(values)), y)
    truth = _tick(scale, "k", float(known.mean()), y) if known.size else ""
    label = group.name if len(group.name) <= 50 else f"{group.name[:47]}..."
    title = f"<title>{escape(group.name)}: {len(values)} items</title>"
    return f'<text class="e" x="{LEFT - 12}" y="{y + 4:.1f}">{escape(label)}{title}</text>{dots}{median}{truth}'


def _tick(scale: Linear, kind: str, value: float, y: float) -> str:
    return f'<path class="{kind}" d="M{scale.place(value):.1f} {y - 9:.1f}v18"/>'
