"""Work-precision diagrams as SVG: cost across, error up, both logarithmic."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence

from stretch_bt.accuracy.job import Domain, Panel
from stretch_bt.accuracy.picture.marks import KEY, entry
from stretch_bt.accuracy.picture.panel import HEIGHT, WIDTH, panel
from stretch_bt.accuracy.points import Row
from stretch_bt.accuracy.summary import Summary, summarise

__all__ = ["draw"]

_ACROSS, _ENTRIES, _LINE = 2, 2, 18  # panels in a row, entries of the legend below each, height of one
_COLORS = ("#0b6e99", "#d1495b", "#2e8b57", "#8a4fbf", "#b8860b", "#c2571a", "#17807e", "#7a1f3d", "#3949ab", "#555555")
_STYLE = (
    "text{font:12px sans-serif;fill:#333}.l{font-size:11px}.d{font-weight:bold}.t{font-weight:bold;font-size:13px}"
    ".m{text-anchor:middle}.e{text-anchor:end}.g{stroke:#e6e6e6}.f{stroke:#777;stroke-dasharray:6 4}"
    ".b{stroke:#777;stroke-dasharray:2 3}.k{stroke:#bbb;stroke-width:1}path{fill:none;stroke-width:1.6}"
)


def draw(name: str, domain: Domain, rows: Iterable[Row]) -> str:
    """Return the picture of a domain: its panels, a line for each series of settings, and the meaning of each mark."""
    found = summarise(rows)
    drawn = [s for p in domain.panels for s in _shown(p, found) if not s.is_reference and _costs(p, s)]
    shown = list(dict.fromkeys(s.setting.series for s in drawn))
    colors = {series: _COLORS[k % len(_COLORS)] for k, series in enumerate(shown)}
    across = max(min(len(domain.panels), _ACROSS), 1)
    panels = [
        f'<g transform="translate({WIDTH * (k % across)} {HEIGHT * (k // across)})">'
        f"{panel(which, domain.kinds[which.kind], _shown(which, found), colors, domain.peers)}</g>"
        for k, which in enumerate(domain.panels)
    ]
    used = [words for mark, words in KEY.items() if any(mark in one for one in panels)]
    legend = [*(entry(color, series, series in domain.peers) for series, color in colors.items()), *used]
    top, columns = HEIGHT * math.ceil(len(domain.panels) / across), across * _ENTRIES
    lines = math.ceil(len(legend) / columns)
    width, height = WIDTH * across, top + _LINE * (lines + 1)
    places = [(30 + width // columns * (k // lines), top + _LINE * (k % lines + 0.5)) for k in range(len(legend))]
    entries = [f'<g transform="translate({x} {y:g})">{text}</g>' for (x, y), text in zip(places, legend, strict=True)]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
    title = f"<title>{html.escape(name)}</title><style>{_STYLE}</style>"
    ground = f'<rect width="{width}" height="{height}" fill="#fff"/>'
    return f"{head}{title}{ground}{''.join(panels)}{''.join(entries)}</svg>\n"


def _costs(which: Panel, summary: Summary) -> bool:
    """Whether a panel has a place for a setting."""
    return any(which.axis.of(row) for row in (*summary.answers, *summary.unanswered))


def _shown(which: Panel, found: Sequence[Summary]) -> list[Summary]:
    """Return the settings that a panel draws: of its series, or of all, where they have its kind of error or failed at it."""
    return [
        summary
        for summary in found
        if (not which.series or summary.setting.series in which.series or summary.is_reference)
        and any(row.error_kind == which.kind for row in (*summary.answers, *summary.unanswered))
    ]
