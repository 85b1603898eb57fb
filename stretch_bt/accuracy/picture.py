"""Work-precision diagrams as SVG: median error across, median CPU time or robot time up, both logarithmic."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stretch_bt.accuracy.points import Kind, Row
from stretch_bt.accuracy.summary import Summary, summarise

__all__ = ["draw"]

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM, _LINE = 520, 400, 64, 16, 34, 48, 18
_ACROSS = 4  # panels in a row
_COLORS = (
    "#0b6e99",
    "#d1495b",
    "#2e8b57",
    "#8a4fbf",
    "#b8860b",
    "#555555",
    "#c2571a",
    "#17807e",
    "#7a1f3d",
    "#3949ab",
    "#000000",
    "#9acd32",
    "#ff69b4",
)
_STYLE = (
    "text{font:12px sans-serif;fill:#333}.g{stroke:#e3e3e3}.f{stroke:#999;stroke-dasharray:5 4}"
    ".t{font-weight:bold}.m{text-anchor:middle}.e{text-anchor:end}path{fill:none;stroke-width:1.6}"
)


class _Dot(NamedTuple):
    error: float
    cost: float
    variant: str


class _Cost(NamedTuple):
    """What is drawn up: CPU ms, or the robot's s where a robot takes any."""

    name: str
    scale: float
    robot: bool

    def of(self, summary: Summary) -> float:
        """Return the median of a summary, 0 where it has none."""
        spread = summary.robot_seconds if self.robot else summary.seconds
        return 0.0 if spread is None else spread.median * self.scale


@dataclass(frozen=True, slots=True)
class _Frame:
    """Maps errors and costs to one panel, by their logarithms."""

    errors: list[float]  # marked on the axis, from its one end to the other
    costs: list[float]

    def x(self, error: float) -> float:
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * max(_share(error, self.errors), 0.0)

    def y(self, cost: float) -> float:
        return _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * _share(cost, self.costs)


def draw(name: str, kinds: Mapping[str, Kind], rows: Iterable[Row]) -> str:
    """Return the picture of a domain: a panel for each kind of error, a line for each series of settings.

    The dashed line is the median of the reference's own error, below which nothing can be told apart; what is far below it
    because it was held to something better stands at the left edge.
    """
    found = summarise(rows)
    cost = _Cost("robot s", 1.0, True) if any(s.robot_seconds for s in found) else _Cost("CPU ms", 1e3, False)
    names = list(dict.fromkeys(s.series for s in found if not s.is_reference and s.answered))
    colors = {series: _COLORS[k % len(_COLORS)] for k, series in enumerate(names)}
    across = min(len(kinds), _ACROSS)
    panels = [
        f'<g transform="translate({_WIDTH * (k % across)} {_HEIGHT * (k // across)})">{_panel(kind, shown, cost, found, colors)}</g>'
        for k, (kind, shown) in enumerate(kinds.items())
    ]
    top, lines = _HEIGHT * math.ceil(len(kinds) / across), math.ceil(len(colors) / across)
    legend = [_entry(top, *divmod(k, lines), series, color) for k, (series, color) in enumerate(colors.items())]
    width, height = _WIDTH * across, top + _LINE * (lines + 1)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
    title = f"<title>{html.escape(name)}</title><style>{_STYLE}</style>"
    ground = f'<rect width="{width}" height="{height}" fill="#fff"/>'
    return f"{head}{title}{ground}{''.join(panels)}{''.join(legend)}</svg>\n"


def _entry(top: int, column: int, line: int, series: str, color: str) -> str:
    x, y = _LEFT + _WIDTH * column, top + _LINE * (line + 0.5)
    mark = f'<path d="M{x} {y}h24" stroke="{color}"/><circle cx="{x + 12}" cy="{y}" r="3.5" fill="{color}"/>'
    return f'{mark}<text x="{x + 32}" y="{y + 4}">{html.escape(series)}</text>'


def _panel(kind: str, shown: Kind, cost: _Cost, found: Sequence[Summary], colors: Mapping[str, str]) -> str:
    series = {name: _dots(kind, shown, cost, [s for s in found if s.series == name]) for name in colors}
    own = [_error(s, kind, shown) for s in found if s.is_reference]
    floor = [max(own)] if any(own) else []
    dots = [dot for group in series.values() for dot in group]
    if not dots:
        return ""
    low = min(floor, default=0.0) / 10
    errors = _marks([*floor, *(max(d.error, low) for d in dots)])
    frame = _Frame(errors, _marks([d.cost for d in dots]))
    lines = [_series(frame, group, colors[name]) for name, group in series.items() if group]
    return _axes(frame, kind, shown, cost) + _floor(frame, floor) + "".join(lines)


def _error(summary: Summary, kind: str, shown: Kind) -> float:
    spread = summary.errors.get(kind)
    return 0.0 if spread is None else spread.median * shown.scale


def _dots(kind: str, shown: Kind, cost: _Cost, summaries: Sequence[Summary]) -> list[_Dot]:
    """Return the dots of a series that a logarithm has a place for."""
    dots = [_Dot(_error(s, kind, shown), cost.of(s), s.variant) for s in summaries if s.answered]
    return [dot for dot in dots if dot.error > 0 and dot.cost > 0]


def _share(value: float, marks: list[float]) -> float:
    """Return where a value lies between the first and the last mark, from 0 to 1, by its logarithm."""
    return math.log(value / marks[0]) / math.log(marks[-1] / marks[0])


def _marks(values: Sequence[float]) -> list[float]:
    """Return the powers of ten that hold all values; 1, 2 and 5 times them where they are within one decade or two."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)
    if high - low > 2:
        return [10.0**power for power in range(low, high + 1)]
    fine = [*(m * 10.0**power for power in range(low, high) for m in (1, 2, 5)), 10.0**high]
    first = max(k for k, mark in enumerate(fine[:-1]) if mark <= min(values) * (1 + 1e-9))
    last = min(k for k, mark in enumerate(fine) if mark >= max(values) * (1 - 1e-9))
    return fine[first : max(last, first + 1) + 1]


def _axes(frame: _Frame, kind: str, shown: Kind, cost: _Cost) -> str:
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    middle = (_LEFT + right) / 2
    parts = [f'<text class="t m" x="{middle:.1f}" y="20">{html.escape(kind.replace("_", " "))}</text>']
    for mark in frame.errors:
        x = frame.x(mark)
        parts.append(f'<path class="g" d="M{x:.1f} {_TOP}V{bottom}"/>')
        parts.append(f'<text class="m" x="{x:.1f}" y="{bottom + 16}">{mark:g}</text>')
    for mark in frame.costs:
        y = frame.y(mark)
        parts.append(f'<path class="g" d="M{_LEFT} {y:.1f}H{right}"/>')
        parts.append(f'<text class="e" x="{_LEFT - 6}" y="{y + 4:.1f}">{mark:g}</text>')
    parts.append(f'<text class="m" x="{middle:.1f}" y="{bottom + 36}">median error, {html.escape(shown.unit)}</text>')
    parts.append(f'<text x="10" y="20">{cost.name}</text>')
    return "".join(parts)


def _floor(frame: _Frame, errors: Sequence[float]) -> str:
    if not errors:
        return ""
    return f'<path class="f" d="M{frame.x(errors[0]):.1f} {_TOP}V{_HEIGHT - _BOTTOM}"/>'


def _series(frame: _Frame, dots: Sequence[_Dot], color: str) -> str:
    places = [(frame.x(dot.error), frame.y(dot.cost)) for dot in dots]
    line = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    circles = [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{color}"><title>{html.escape(dot.variant)}</title></circle>'
        for (x, y), dot in zip(places, dots, strict=True)
    ]
    return f'<path d="M{line}" stroke="{color}"/>{"".join(circles)}'
