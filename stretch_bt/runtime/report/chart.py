"""Two quantities against each other as inline SVG: lines, and marks with the errors of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stretch_bt.draw.axes import Frame, columns, rows, words
from stretch_bt.draw.scale import Linear
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


def chart(name: str, across: str, up: str, lines: Sequence[Line], marks: Sequence[Mark]) -> str:
    """Return the figure, with 0 on both axes; `across` and `up` name them with their units."""
    xs = [x for line in lines for x, _ in line.points] + [m.x + s * m.x_sd for m in marks for s in (-1, 1)]
    ys = [y for line in lines for _, y in line.points] + [m.y + s * m.y_sd for m in marks for s in (-1, 1)]
    below, beside = Linear(*_range(xs), LEFT, WIDTH - RIGHT), Linear(*_range(ys), HEIGHT - BOTTOM, TOP)
    frame = Frame(below, beside)
    drawing = _axes(below, beside, across, up) + "".join(_line(frame, line) for line in lines if line.points)
    drawing += "".join(_mark(frame, mark) for mark in marks)
    named = {line.name: line.color for line in lines if line.name}
    legend = "".join(f'<span><i style="background:{color}"></i>{escape(text)}</span>' for text, color in named.items())
    caption = f'<b>{escape(name)}</b> <span class="legend">{legend}</span>'
    return f'<figure><figcaption>{caption}</figcaption><svg viewBox="0 0 {WIDTH} {HEIGHT}">{drawing}</svg></figure>'


def _range(values: Sequence[float]) -> tuple[float, float]:
    low, high = min([0.0, *values]), max([0.0, *values])
    margin = 0.05 * (high - low) or 1.0
    return (low - margin if low < 0 else 0.0), high + margin


def _axes(xs: Linear, ys: Linear, across: str, up: str) -> str:
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    return (
        rows([(ys.place(value), number(value, 5)) for value in ys.ticks(6)], LEFT, right)
        + columns([(xs.place(value), number(value, 5)) for value in xs.ticks(7)], TOP, bottom, bottom + 15)
        + words((LEFT + right) / 2, HEIGHT - 6, across, "c")
        + words(4, 12, up)
    )


def _line(frame: Frame, line: Line) -> str:
    path = "L".join(f"{frame.x(x):.1f} {frame.y(y):.1f}" for x, y in line.points)
    dashes = ";stroke-dasharray:4 3;stroke-width:1.1" if line.dashed else ""
    return f'<path class="l" style="stroke:{line.color}{dashes}" d="M{path}"/>'


def _mark(frame: Frame, mark: Mark) -> str:
    x, y = frame.x(mark.x), frame.y(mark.y)
    bars = f"M{frame.x(mark.x - mark.x_sd):.1f} {y:.1f}H{frame.x(mark.x + mark.x_sd):.1f}"
    bars += f"M{x:.1f} {frame.y(mark.y - mark.y_sd):.1f}V{frame.y(mark.y + mark.y_sd):.1f}"
    label = words(x + 5, y + 14, mark.label) if mark.label else ""
    look = f"fill:none;stroke:{mark.color};stroke-width:1.6" if mark.hollow else f"fill:{mark.color}"
    title = f"<title>{escape(mark.title)}</title>" if mark.title else ""
    circle = (
        f'<circle class="d" cx="{x:.1f}" cy="{y:.1f}" r="{4.5 if mark.hollow else 2.6}" style="{look}">{title}</circle>'
    )
    return f'<path class="l" style="stroke:{mark.color};stroke-width:1" d="{bars}"/>{circle}{label}'
