"""The rows of a domain as a table for people."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from stretch_bt.accuracy.job import CPU_MS, ROBOT_S, Domain
from stretch_bt.accuracy.points import Kind, Row
from stretch_bt.accuracy.summary import Spread, Summary, summarise

__all__ = ["number", "table"]


def table(name: str, domain: Domain, rows: Iterable[Row]) -> str:
    """Return the figures of a domain: its reference with its own error, each setting, and the cases without an answer."""
    found = summarise(rows)
    parts = [f"{name}\n{domain.about}"]
    for together in _together(found, domain.kinds):
        shown = [s for s in found if together.keys() & s.kinds()]
        parts.append(_grid("reference", [s for s in shown if s.is_reference], together))
        parts.append(_grid("setting", [s for s in shown if not s.is_reference], together))
    parts.append(_missing("without an answer", [row for s in found for row in s.unanswered]))
    parts.append(_missing("not run", [row for s in found for row in s.skipped]))
    return "\n\n".join(part for part in parts if part)


def _together(summaries: list[Summary], kinds: Mapping[str, Kind]) -> list[dict[str, Kind]]:
    """Return the kinds in groups that no setting bridges, so that no table is mostly empty."""
    groups: list[set[str]] = []
    for summary in summaries:
        met = [group for group in groups if group & summary.kinds()]
        groups = [group for group in groups if group not in met] + [summary.kinds().union(*met)]
    named = [{kind: shown for kind, shown in kinds.items() if kind in group} for group in groups]
    return sorted((group for group in named if group), key=lambda group: [*kinds].index(next(iter(group))))


def _grid(title: str, summaries: list[Summary], kinds: Mapping[str, Kind]) -> str:
    if not summaries:
        return ""
    axes = [ROBOT_S, CPU_MS] if any(s.costs(ROBOT_S.of) for s in summaries) else [CPU_MS]
    names = [axis.name for axis in axes] + [f"{kind.replace('_', ' ')}, {k.unit}" for kind, k in kinds.items()]
    spread = ["median / p95" for _ in axes] + ["median / p95 / largest" for _ in kinds]
    lines = [[title, "cases", "failed", *names], ["", "", "", *spread]]
    for summary in summaries:
        costs = [_cost(summary.costs(axis.of)) for axis in axes]
        lines.append(
            [_name(summary), str(summary.answered), str(len(summary.unanswered)), *costs, *_errors(summary, kinds)]
        )
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    return "\n".join(_aligned(line, widths) for line in lines)


def _name(summary: Summary) -> str:
    return f"{summary.setting} (default)" if summary.default else str(summary.setting)


def _aligned(line: list[str], widths: list[int]) -> str:
    first, *rest = (
        cell.rjust(width) if column else cell.ljust(width)
        for column, (cell, width) in enumerate(zip(line, widths, strict=True))
    )
    return "  ".join([first, *rest]).rstrip()


def _errors(summary: Summary, kinds: Mapping[str, Kind]) -> Iterator[str]:
    for kind, shown in kinds.items():
        spread = summary.errors(kind)
        values = () if spread is None else (spread.median, spread.p95, spread.largest)
        yield " / ".join(number(value * shown.scale) for value in values) or "-"


def _cost(spread: Spread | None) -> str:
    return "-" if spread is None else f"{number(spread.median)} / {number(spread.p95)}"


def number(value: float) -> str:
    """Return two significant digits, without an exponent where that is short."""
    if value == 0 or 0.001 <= value < 10:
        return f"{value:.2g}"
    return f"{value:.0f}" if 10 <= value < 1e6 else f"{value:.0e}"


def _missing(title: str, rows: Iterable[Row]) -> str:
    """Return which setting gave no answer to which case, and why; one line where a setting has the same reason more than once."""
    found: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        found.setdefault((str(row.setting), f"{row.status}: {row.reason}"), []).append(row.case)
    lines = [
        f"  {setting}: {cases[0] if len(cases) == 1 else f'{len(cases)} cases'}: {why}"
        for (setting, why), cases in found.items()
    ]
    return "\n".join([title, *lines]) if lines else ""
