"""Places for labels beside their points, where they hide nothing."""

from __future__ import annotations

import html
from typing import NamedTuple

__all__ = ["Label", "LabelBox", "placed"]

_LETTER, _LINE = 6.1, 12.0  # width and height of a letter
_NEAR, _STEP, _FAR = 10.0, 13.0, 9
#: directions in which a label may stand from its point, and which end of it is nearest
_WAYS = ((1, 0, ""), (-1, 0, "e"), (0, -1, "m"), (0, 1, "m"), (1, -1, ""), (1, 1, ""), (-1, -1, "e"), (-1, 1, "e"))


class LabelBox(NamedTuple):
    """A rectangle: left, top, right and bottom."""

    left: float
    top: float
    right: float
    bottom: float

    def shared(self, other: LabelBox) -> float:
        """Return the area of both."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return max(wide, 0.0) * max(high, 0.0)

    def beyond(self, other: LabelBox) -> float:
        """Return the area of this one that is not in another."""
        return (self.right - self.left) * (self.bottom - self.top) - self.shared(other)


class Label(NamedTuple):
    """A text beside a point."""

    x: float
    y: float
    text: str
    color: str
    bold: bool = False


def placed(labels: list[Label], taken: list[LabelBox], room: LabelBox) -> str:
    """Return labels as SVG, each at the nearest place that hides nothing taken, those in bold first."""
    taken, parts = [*taken], []
    for label in sorted(labels, key=lambda label: not label.bold):
        x, y, end = min(_places(label), key=lambda place: _hidden(label, place, taken, room))
        taken.append(_box(label, x, y, end))
        parts.append(_drawn(label, x, y, end))
    return "".join(parts)


def _places(label: Label) -> list[tuple[float, float, str]]:
    return [
        (label.x + across * distance, label.y + down * distance + 4, end)
        for distance in (_NEAR + _STEP * k for k in range(_FAR))
        for across, down, end in _WAYS
    ]


def _hidden(label: Label, place: tuple[float, float, str], taken: list[LabelBox], room: LabelBox) -> float:
    box = _box(label, *place)
    return round(sum(box.shared(other) for other in taken) + 3 * box.beyond(room), 3)


def _box(label: Label, x: float, y: float, end: str) -> LabelBox:
    wide = len(label.text) * _LETTER * (1.08 if label.bold else 1.0)
    left = x - {"": 0.0, "m": wide / 2, "e": wide}[end]
    return LabelBox(left, y - _LINE + 2, left + wide, y + 3)


def _drawn(label: Label, x: float, y: float, end: str) -> str:
    classes = " ".join(filter(None, ("l", "d" if label.bold else "", end)))
    far = abs(x - label.x) > _NEAR + 1 or abs(y - 4 - label.y) > _NEAR + 1
    leader = f'<path class="k" d="M{label.x:.1f} {label.y:.1f}L{x:.1f} {y - 4:.1f}"/>' if far else ""
    return f'{leader}<text class="{classes}" x="{x:.1f}" y="{y:.1f}" style="fill:{label.color}">{html.escape(label.text)}</text>'
