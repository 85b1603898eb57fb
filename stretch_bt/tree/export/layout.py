"""Where the boxes of a drawing stand: depth to the right, order downwards, a parent level with its first child.

Siblings close up where their children leave room, but no two families share a stretch of the gap between two columns,
so that every line leads to one place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from stretch_bt.tree.export.style import glyph, sign
from stretch_bt.tree.export.view import NodeView

__all__ = ["CHAR", "HEADING", "LINE", "PAD", "NodeBox", "arrange"]

#: px: width of a character of the small monospaced text, height of a line of it and of the heading, padding
CHAR, LINE, HEADING, PAD = 6.65, 15.0, 20.0, 10.0
HEAVY = 8.3  # px of a character of the heading, a generous mean
GAP_X, GAP_Y = 34.0, 9.0
LONGEST = 54  # characters of a line; the rest is in the tooltip


@dataclass(slots=True)
class NodeBox:
    """One box, px from the top left of the drawing."""

    view: NodeView
    heading: str
    around: list[str]
    lines: list[tuple[str, str]]
    width: float
    height: float
    x: float = 0.0
    y: float = 0.0
    is_finally: bool = False
    merged: NodeView | None = None
    children: list[NodeBox] = field(default_factory=list)

    @property
    def anchor(self) -> float:
        """Height at which lines arrive and leave."""
        return self.y + PAD / 2 + LINE * len(self.around) + HEADING / 2

    def walk(self) -> Iterator[NodeBox]:
        """Yield the box and all to the right of it."""
        yield self
        for child in self.children:
            yield from child.walk()


def arrange(roots: list[NodeView], x: float, y: float) -> tuple[list[NodeBox], float, float]:
    """Return placed boxes of these trees, one under the other from (x, y), with the right and lower edge of all."""
    boxes = [_box(view) for view in roots]
    widths: dict[int, float] = {}
    for box in boxes:
        _measure(box, 0, widths)
    columns = [x]
    for depth in range(len(widths)):
        columns.append(columns[-1] + widths[depth] + GAP_X)
    edges = [y] * len(columns)
    for box in boxes:
        _place(box, 0, columns, edges)
        edges = [max(edges) + 3 * GAP_Y] * len(columns)
    return boxes, columns[-1] - GAP_X, max(edges)


def _box(view: NodeView, is_finally: bool = False) -> NodeBox:
    around = [_short(text, LONGEST) for text, _ in view.around]
    lines = [(name, _short(value, LONGEST - len(name))) for name, value in view.settings.items()]
    heading = glyph(view)
    inside = _merged(view)
    if inside is not None:
        heading = f"{heading}  {sign(inside)}"
    longest = max((len(a) for a in around), default=0), max((len(n) + 2 + len(v) for n, v in lines), default=0)
    width = max(HEAVY * len(heading), CHAR * max(longest)) + 2 * PAD
    height = PAD + LINE * len(around) + HEADING + LINE * len(lines)
    found = NodeBox(view, heading, around, lines, width, height, is_finally=is_finally, merged=inside)
    found.children = [_box(child) for child in (inside or view).children]
    if view.finish is not None:
        found.children.append(_box(view.finish, True))
    return found


def _merged(view: NodeView) -> NodeView | None:
    """Return the only child when it is a plain group, whose sign then stands in the parent's box."""
    if len(view.children) != 1:
        return None
    child = view.children[0]
    plain = child.title == child.keyword and not child.around and not child.settings
    return child if plain and sign(child) and len(child.children) > 1 else None


def _short(text: str, length: int) -> str:
    length = max(length, 12)
    return text if len(text) <= length else f"{text[: length - 1]}…"


def _measure(box: NodeBox, depth: int, widths: dict[int, float]) -> None:
    widths[depth] = max(widths.get(depth, 0.0), box.width)
    for child in box.children:
        _measure(child, depth + 1, widths)


def _place(box: NodeBox, depth: int, columns: list[float], edges: list[float]) -> None:
    """Place a box and all to the right of it; `edges` are the heights at which each column is free."""
    box.x, box.y = columns[depth], _free(box, depth, edges)
    edges[depth] = box.y + box.height + GAP_Y
    if box.children:
        edges[depth + 1] = max(edges[depth + 1], box.y)
    for child in box.children:
        edges[depth + 1] += LINE - GAP_Y if child.is_finally else 0.0  # room for the word over it
        _place(child, depth + 1, columns, edges)


def _free(box: NodeBox, depth: int, edges: list[float]) -> float:
    """Return the height at which a box can stand level with its first child, and that with its own first."""
    return max(edges[depth], _free(box.children[0], depth + 1, edges)) if box.children else edges[depth]
