"""Two quantities against each other as inline SVG: lines, and marks with the errors of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stretch_bt.runtime.report.scale import ticks
from stretch_bt.runtime.report.text import escape, number

__all__ = ["Line", "Mark", "chart"]

WIDTH, HEIGHT = 460, 330
LEFT, RIGHT, TOP, BOTTOM = 46, 14, 22, 38


@dataclass(frozen=True, slots=True)
class Line:
    """Points (x, y) in the units shown, joined; `name` stands in the legend where there is one."""

    points: Sequence[tuple[float, float]]
    color: str
    name: str = ""
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Mark:
    """A point with its standard deviations, in the units shown; `label` stands beside it, `title` is what it says of itself."""

    x: float
    y: float
    color: str
    x_sd: float = 0.0
    y_sd: float = 0.0
    label: str = ""
    title: str = ""
    hollow: bool = False


@dataclass(frozen=True, slots=True)
class _Frame:
    """Maps both quantities to the drawing."""

    across: tuple[float, float]
    up: tuple[float, float]

    def x(self, value: float) -> float:
        low, high = self.across
        return LEFT + (WIDTH - LEFT - RIGHT) * (value - low) / (high - low)

    def y(self, value: float) -> float:
        low, high = self.up
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - low) / (high - low)


def chart(name: str, across: str, up: str, lines: Sequence[Line], marks: Sequence[Mark]) -> str:
    """Return the figure, with 0 on both axes; `across` and `up` name them with their units."""
    xs = [x for line in lines for x, _ in line.points] + [m.x + s * m.x_sd for m in marks for s in (-1, 1)]
    ys = [y for line in lines for _, y in line.points] + [m.y + s * m.y_sd for m in marks for s in (-1, 1)]
    frame = _Frame(_range(xs), _range(ys))
    drawing = _axes(frame, across, up) + "".join(_line(frame, line) for line in lines if line.points)
    drawing += "".join(_mark(frame, mark) for mark in marks)
    named = {line.name: line.color for line in lines if line.name}
    legend = "".join(f'<span><i style="background:{color}"></i>{escape(text)}</span>' for text, color in named.items())
    caption = f'<b>{escape(name)}</b> <span class="legend">{legend}</span>'
    return f'<figure><figcaption>{caption}</figcaption><svg viewBox="0 0 {WIDTH} {HEIGHT}">{drawing}</svg></figure>'


def _range(values: Sequence[float]) -> tuple[float, float]:
    low, high = min([0.0, *values]), max([0.0, *values])
    margin = 0.05 * (high - low) or 1.0
    return (low - margin if low < 0 else 0.0), high + margin


def _axes(frame: _Frame, across: str, up: str) -> str:
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    parts = []
    for value in ticks(*frame.up, 6):
        y = frame.y(value)
        parts.append(f'<path class="g" d="M{LEFT} {y:.1f}H{right}"/>')
        parts.append(f'<text class="r" x="{LEFT - 6}" y="{y + 3.5:.1f}">{number(value, 5)}</text>')
    for value in ticks(*frame.across, 7):
        x = frame.x(value)
        parts.append(f'<path class="g" d="M{x:.1f} {TOP}V{bottom}"/>')
        parts.append(f'<text class="c" x="{x:.1f}" y="{bottom + 15}">{number(value, 5)}</text>')
    parts.append(f'<text class="c" x="{(LEFT + right) / 2:.1f}" y="{HEIGHT - 6}">{escape(across)}</text>')
    parts.append(f'<text x="4" y="12">{escape(up)}</text>')
    return "".join(parts)


def _line(frame: _Frame, line: Line) -> str:
    path = "L".join(f"{frame.x(x):.1f} {frame.y(y):.1f}" for x, y in line.points)
    dashes = ";stroke-dasharray:4 3;stroke-width:1.1" if line.dashed else ""
    return f'<path class="l" style="stroke:{line.color}{dashes}" d="M{path}"/>'


def _mark(frame: _Frame, mark: Mark) -> str:
    x, y = frame.x(mark.x), frame.y(mark.y)
    bars = f"M{frame.x(mark.x - mark.x_sd):.1f} {y:.1f}H{frame.x(mark.x + mark.x_sd):.1f}"
    bars += f"M{x:.1f} {frame.y(mark.y - mark.y_sd):.1f}V{frame.y(mark.y + mark.y_sd):.1f}"
    label = f'<text x="{x + 5:.1f}" y="{y + 14:.1f}">{escape(mark.label)}</text>' if mark.label else ""
    look = f"fill:none;stroke:{mark.color};stroke-width:1.6" if mark.hollow else f"fill:{mark.color}"
    title = f"<title>{escape(mark.title)}</title>" if mark.title else ""
    circle = (
        f'<circle class="d" cx="{x:.1f}" cy="{y:.1f}" r="{4.5 if mark.hollow else 2.6}" style="{look}">{title}</circle>'
    )
    return f'<path class="l" style="stroke:{mark.color};stroke-width:1" d="{bars}"/>{circle}{label}'
