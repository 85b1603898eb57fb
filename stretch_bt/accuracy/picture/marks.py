"""The looks of points, bars and failures."""

from __future__ import annotations

import html

from stretch_bt.accuracy.summary import MANY

__all__ = ["KEY", "bar", "entry", "open_mark", "point"]

_SIZE, _RING, _CAP = 4.0, 8.0, 4.0


def point(x: float, y: float, color: str, *, peer: bool, default: bool, title: str = "") -> str:
    """Return a filled circle, a square for another program, with a ring where it is the default."""
    told = f"<title>{html.escape(title)}</title>" if title else ""
    if peer:
        mark = f'<rect x="{x - _SIZE:.1f}" y="{y - _SIZE:.1f}" width="8" height="8" fill="{color}">{told}</rect>'
    else:
        mark = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{_SIZE:g}" fill="{color}">{told}</circle>'
    ring = f'<circle class="r" cx="{x:.1f}" cy="{y:.1f}" r="{_RING:g}" fill="none" stroke="#111" stroke-width="1.8"/>'
    return mark + (ring if default else "")


def bar(x: float, low: float, high: float, color: str, *, many: bool) -> str:
    """Return a bar from one place up to another: its end is flat for a 95th percentile, pointed for the largest."""
    end = f"M{x - _CAP:.1f} {high:.1f}h{2 * _CAP:g}" if many else f"M{x - _CAP:.1f} {high + _CAP:.1f}l4 -4l4 4"
    return f'<path d="M{x:.1f} {low:.1f}V{high:.1f}{end}" stroke="{color}" style="stroke-width:1.1"/>'


def open_mark(x: float, y: float, color: str) -> str:
    """Return the mark of cases without an answer."""
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{_SIZE:g}" fill="#fff" stroke="{color}" stroke-width="1.6"/>'


def entry(color: str, words: str, peer: bool) -> str:
    """Return an entry of the legend for a series."""
    line = f'<path d="M0 0h24" stroke="{color}"/>' + point(12, 0, color, peer=peer, default=False)
    return f'{line}<text x="32" y="4">{html.escape(words)}</text>'


def _key(mark: str, words: str) -> str:
    return f'{mark}<text x="32" y="4">{words}</text>'


#: entries of the legend that explain a mark, by a piece of text that a panel has where the mark is drawn
KEY = {
    "<circle": _key(point(12, 0, "#777", peer=False, default=True), "median; the ring is the default"),
    f'h{2 * _CAP:g}" stroke': _key(bar(12, 8, -6, "#777", many=True), f"95th percentile, of {MANY} cases or more"),
    'l4 -4l4 4" stroke': _key(bar(12, 8, -6, "#777", many=False), "largest, of fewer cases"),
    'fill="#fff" stroke': _key(open_mark(12, 0, "#777"), "cases without an answer"),
    'class="f"': _key('<path class="f" d="M0 0h24"/>', "the reference's own error, median"),
}
