"""Small maps of a quantity over two others, side by side, as inline SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stretch_bt.draw.axes import BASELINE, words
from stretch_bt.runtime.report.text import escape, number

__all__ = ["Map", "Tile", "heatmaps", "tint"]

WIDTH, LEFT, TOP, BOTTOM, GAP = 460, 30, 26, 34, 8
ROW = 10  # px, height of a tile
UNKNOWN = "#d4d8de"
#: colours from -1 over 0 to 1
_BELOW, _NONE, _ABOVE = (33, 102, 172), (250, 250, 248), (178, 24, 43)


@dataclass(frozen=True, slots=True)
class Tile:
    """A value at a place; None where there is none. `framed` draws a line around it, `title` is what it says of itself."""

    across: float
    down: float
    value: float | None
    framed: bool = False
    title: str = ""


@dataclass(frozen=True, slots=True)
class Map:
    """Tiles under a name."""

    name: str
    tiles: Sequence[Tile]


def tint(part: float) -> str:
    """Return a colour for a number: blue at -1 and below, white at 0, red at 1 and above."""
    part = min(max(part, -1.0), 1.0)
    end = _ABOVE if part > 0 else _BELOW
    return "#" + "".join(f"{round(a + (b - a) * abs(part)):02x}" for a, b in zip(_NONE, end, strict=True))


def heatmaps(name: str, across: str, down: str, maps: Sequence[Map], most: float) -> str:
    """Return the figure: places across and down from 0, named with their units; colours are full at `most`."""
    columns = sorted({tile.across for one in maps for tile in one.tiles})
    rows = sorted({tile.down for one in maps for tile in one.tiles})
    width = (WIDTH - LEFT) / max(len(maps), 1) - GAP
    step, height = width / max(len(columns), 1), TOP + ROW * len(rows)
    parts = [_rows(rows), words(2, 10, down)]
    for k, one in enumerate(maps):
        left = LEFT + k * (width + GAP)
        parts.append(words(left + width / 2, TOP - 5, one.name, "c"))
        parts += [
            _tile(tile, left + step * columns.index(tile.across), TOP + ROW * rows.index(tile.down), step, most)
            for tile in one.tiles
        ]
        parts += [
            words(left + step * (c + 0.5), height + 12, number(columns[c], 3), "c") for c in _few(len(columns), 3)
        ]
    parts.append(words((LEFT + WIDTH) / 2, height + 27, across, "c"))
    drawing = f'<svg viewBox="0 0 {WIDTH} {height + BOTTOM}">{"".join(parts)}</svg>'
    return f"<figure><figcaption><b>{escape(name)}</b></figcaption>{drawing}</figure>"


def _rows(rows: Sequence[float]) -> str:
    return "".join(
        words(LEFT - 4, TOP + ROW * (r + 0.5) + BASELINE, number(rows[r], 3), "r") for r in _few(len(rows), 8)
    )


def _few(count: int, most: int) -> range:
    """Return some of so many places, evenly from the first on."""
    return range(0, count, max(1, -(-count // most)))


def _tile(tile: Tile, x: float, y: float, width: float, most: float) -> str:
    color = UNKNOWN if tile.value is None else tint(tile.value / most)
    edge = ' stroke="#1c2430" stroke-width="0.9"' if tile.framed else ""
    title = f"<title>{escape(tile.title)}</title>" if tile.title else ""
    return (
        f'<rect x="{x + 0.5:.1f}" y="{y + 0.5:.1f}" width="{max(width - 1, 1):.1f}" height="{ROW - 1}" fill="{color}"{edge}>'
        f"{title}</rect>"
    )
