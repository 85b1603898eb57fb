"""A quantity against time as inline SVG: a line that holds each value until the next, in a band of one sd."""

from __future__ import annotations

from stretch_bt.draw.axes import Frame, columns, rows
from stretch_bt.draw.scale import Linear
from stretch_bt.runtime.report.history import Series
from stretch_bt.runtime.report.text import escape, number, seconds

__all__ = ["plot"]

WIDTH, HEIGHT = 460, 170
LEFT, RIGHT, TOP, BOTTOM = 58, 10, 10, 26
COLUMNS = 500

Point = tuple[float, float, float | None]


def plot(series: Series, start: float, end: float) -> str:
    """Return the figure of a series over a time range, s."""
    scale, unit = (series.kind.scale, series.kind.unit) if series.kind else (1.0, "SI")
    shown = [(t, v / scale, None if sd is None else sd / scale) for t, v, sd in series.points]
    times = Linear(start, end if end > start else start + 1.0, LEFT, WIDTH - RIGHT)
    values = Linear(*_range(shown), HEIGHT - BOTTOM, TOP)
    frame, points = Frame(times, values), _thin(shown, times)
    last = f"{number(shown[-1][1])} {escape(unit) if series.kind else ''}"
    drawing = _grid(times, values) + _band(points, frame, times.high) + _line(points, frame)
    caption = f"<b>{escape(series.name)}</b> <span>{escape(unit)}</span><em>{last}</em>"
    return f'<figure><figcaption>{caption}</figcaption><svg viewBox="0 0 {WIDTH} {HEIGHT}">{drawing}</svg></figure>'


def _range(points: list[Point]) -> tuple[float, float]:
    low = min(value - (sd or 0.0) for _, value, sd in points)
    high = max(value + (sd or 0.0) for _, value, sd in points)
    margin = 0.06 * (high - low) or 0.05 * abs(high) or 1.0
    return low - margin, high + margin


def _thin(points: list[Point], times: Linear) -> list[Point]:
    """Keep of each column of the drawing the first, the least, the greatest and the last."""
    if len(points) <= 4 * COLUMNS:
        return points
    columns: dict[int, list[int]] = {}
    for index, (time, _, _) in enumerate(points):
        columns.setdefault(int(COLUMNS * (time - times.low) / (times.high - times.low)), []).append(index)
    kept: set[int] = set()
    for indices in columns.values():
        kept |= {indices[0], indices[-1]}
        kept |= {pick(indices, key=lambda i: points[i][1]) for pick in (min, max)}
    return [points[index] for index in sorted(kept)]


def _grid(times: Linear, values: Linear) -> str:
    across = [(times.place(time), f"{seconds(time)} s") for time in times.ticks(6)]
    up = [(values.place(value), number(value, 5)) for value in values.ticks(4)]
    bottom = HEIGHT - BOTTOM
    return rows(up, LEFT, WIDTH - RIGHT) + columns(across, TOP, bottom, bottom + 15)


def _steps(points: list[tuple[float, float]]) -> str:
    head, *rest = points
    moves = [f"M{head[0]:.1f} {head[1]:.1f}", *(f"H{x:.1f}V{y:.1f}" for x, y in rest)]
    return "".join(moves)


def _line(points: list[Point], frame: Frame) -> str:
    places = [(frame.x(time), frame.y(value)) for time, value, _ in points]
    path = f'<path class="l" d="{_steps(places)}H{WIDTH - RIGHT:.1f}"/>'
    dots = places if len(places) <= 60 else places[-1:]
    return path + "".join(f'<circle class="d" cx="{x:.1f}" cy="{y:.1f}" r="1.8"/>' for x, y in dots)


def _band(points: list[Point], frame: Frame, end: float) -> str:
    bars = [
        f"M{frame.x(t):.1f} {frame.y(v - sd):.1f}H{frame.x(until):.1f}V{frame.y(v + sd):.1f}H{frame.x(t):.1f}Z"
        for (t, v, sd), until in zip(points, [*(p[0] for p in points[1:]), end], strict=True)
        if sd
    ]
    return f'<path class="b" d="{"".join(bars)}"/>' if bars else ""
