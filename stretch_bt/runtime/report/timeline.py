"""The statuses of all nodes over time as inline SVG: one row a node, in the order of the tree."""

from __future__ import annotations

from stretch_bt.draw.axes import columns
from stretch_bt.draw.scale import Linear
from stretch_bt.runtime.report.history import Span
from stretch_bt.runtime.report.text import escape, seconds

__all__ = ["legend", "timeline"]

WIDTH, LABELS, ROW, TOP, RIGHT = 980, 270, 18, 22, 12
MARK = 3.0


def timeline(spans: dict[str, list[Span]], start: float, end: float) -> str:
    """Return the figure, or nothing for a run without nodes."""
    rows = _rows(list(spans))
    if not rows:
        return ""
    end = end if end > start else start + 1.0
    height = TOP + ROW * len(rows) + 6
    times = Linear(start, end, LABELS, WIDTH - RIGHT)
    marks = [(times.place(time), f"{seconds(time)} s") for time in times.ticks(9)]
    parts = [columns(marks, TOP - 4, height - 4, TOP - 9)]
    for index, (path, depth) in enumerate(rows):
        parts.append(_label(path, depth, index))
        parts += [_bar(path, span, index, times) for span in spans.get(path, [])]
    return f'<svg class="t" viewBox="0 0 {WIDTH} {height}">{"".join(parts)}</svg>'


def legend() -> str:
    """Return the key to the colours."""
    names = {"running": "running", "success": "success", "failure": "failure", "invalid": "interrupted"}
    items = "".join(f'<span><i class="s-{kind}"></i>{name}</span>' for kind, name in names.items())
    return f'<span class="legend">{items}</span>'


def _rows(paths: list[str]) -> list[tuple[str, int]]:
    """Return each path and its depth, parents before children, siblings as they first appeared."""
    children: dict[str, list[str]] = {}
    known = set()
    for path in paths:
        parts = path.split("/")
        for end in range(1, len(parts) + 1):
            prefix = "/".join(parts[:end])
            if prefix not in known:
                known.add(prefix)
                children.setdefault("/".join(parts[: end - 1]), []).append(prefix)
    rows = []
    waiting = [(root, 0) for root in reversed(children.get("", []))]
    while waiting:
        path, depth = waiting.pop()
        rows.append((path, depth))
        waiting += [(child, depth + 1) for child in reversed(children.get(path, []))]
    return rows


def _label(path: str, depth: int, index: int) -> str:
    name = path.rpartition("/")[2]
    indent = 6 + 11 * depth
    room = int((LABELS - 10 - indent) / 6.2)
    shown = name if len(name) <= room else name[: max(room - 1, 1)] + "…"
    y = TOP + ROW * index
    shade = f'<rect class="z" x="0" y="{y}" width="{WIDTH}" height="{ROW}"/>' if index % 2 else ""
    return f'{shade}<text x="{indent}" y="{y + 12.5}">{escape(shown)}<title>{escape(path)}</title></text>'


def _bar(path: str, span: Span, index: int, times: Linear) -> str:
    x = times.place(span.start)
    width = max(times.place(span.end) - x, MARK)
    shift = 0 if span.status == "RUNNING" else MARK / 2
    y = TOP + ROW * index + 3
    when = f"{seconds(span.start)} s" if span.end == span.start else f"{seconds(span.start)} to {seconds(span.end)} s"
    title = escape(f"{path}\n{span.status} {when}\n{span.reason}".rstrip())
    kind = escape(span.status.lower())
    return f'<rect class="s-{kind}" x="{x - shift:.1f}" y="{y}" width="{width:.1f}" height="{ROW - 6}" rx="1.5"><title>{title}</title></rect>'
