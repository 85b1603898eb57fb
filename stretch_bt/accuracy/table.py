"""The rows of a domain as a table for people."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from stretch_bt.accuracy.points import Kind, Row
from stretch_bt.accuracy.summary import Spread, Summary, summarise

__all__ = ["table"]


def table(name: str, about: str, kinds: Mapping[str, Kind], rows: Iterable[Row]) -> str:
    """Return what a domain measured: its reference with its own error, each setting, and what has no answer."""
    found = summarise(rows)
    parts = [f"{name}\n{about}"]
    for together in _together(found, kinds):
        shown = [s for s in found if s.answered and together.keys() & s.errors.keys()]
        parts.append(_grid("reference", [s for s in shown if s.is_reference], together))
        parts.append(_grid("setting", [s for s in shown if not s.is_reference], together))
    parts.append(_missing(found))
    return "\n\n".join(part for part in parts if part)


def _together(summaries: list[Summary], kinds: Mapping[str, Kind]) -> list[dict[str, Kind]]:
    """Return the kinds in groups that no setting bridges, so that no table is mostly empty."""
    groups: list[set[str]] = []
    for summary in summaries:
        met = [group for group in groups if group & summary.errors.keys()]
        groups = [group for group in groups if group not in met] + [set(summary.errors).union(*met)]
    named = [{kind: shown for kind, shown in kinds.items() if kind in group} for group in groups]
    return sorted((group for group in named if group), key=lambda group: [*kinds].index(next(iter(group))))


def _grid(title: str, summaries: list[Summary], kinds: Mapping[str, Kind]) -> str:
    if not summaries:
        return ""
    robot = any(s.robot_seconds for s in summaries)
    costs = ["robot s", "CPU ms"] if robot else ["CPU ms"]
    headings = [
        title,
        "cases",
        "failed",
        *costs,
        *(f"{kind.replace('_', ' ')}, {k.unit}" for kind, k in kinds.items()),
    ]
    spread = ["", "", "", *("median / p95" for _ in costs), *("median / p95 / largest" for _ in kinds)]
    lines = [headings, spread, *([*_line(s, kinds, robot)] for s in summaries)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(headings))]
    return "\n".join(_aligned(line, widths) for line in lines)


def _aligned(line: list[str], widths: list[int]) -> str:
    first, *rest = (
        cell.rjust(width) if column else cell.ljust(width)
        for column, (cell, width) in enumerate(zip(line, widths, strict=True))
    )
    return "  ".join([first, *rest]).rstrip()


def _line(summary: Summary, kinds: Mapping[str, Kind], robot: bool) -> Iterator[str]:
    yield summary.setting
    yield str(summary.answered)
    yield str(len(summary.unanswered))
    if robot:
        yield _cost(summary.robot_seconds, 1.0)
    yield _cost(summary.seconds, 1e3)
    for kind, shown in kinds.items():
        yield _spread(summary.errors.get(kind), shown.scale)


def _cost(spread: Spread | None, scale: float) -> str:
    return "-" if spread is None else f"{_number(spread.median * scale)} / {_number(spread.p95 * scale)}"


def _spread(spread: Spread | None, scale: float) -> str:
    if spread is None:
        return "-"
    return " / ".join(_number(value * scale) for value in (spread.median, spread.p95, spread.largest))


def _number(value: float) -> str:
    """Return two significant digits, without an exponent where that is short."""
    if value == 0 or 0.001 <= value < 10:
        return f"{value:.2g}"
    return f"{value:.0f}" if 10 <= value < 1e6 else f"{value:.0e}"


def _missing(summaries: list[Summary]) -> str:
    """Return who gave no answer to what, and why."""
    lines = [f"  {row.setting}: {row.case}: {row.status}" for s in summaries for row in s.unanswered]
    return "\n".join(["without an answer", *lines]) if lines else ""
