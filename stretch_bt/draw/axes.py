"""Axes of a plot as SVG: lines of the grid with their labels.

The style sheet of the drawing gives the looks: class `g` is a line of the grid. The class of a label anchors it: labels below
or above a plot are centred, those beside it end where it begins.
"""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import NamedTuple

from stretch_bt.draw.scale import Scale

__all__ = ["BASELINE", "Frame", "columns", "rows", "words"]

BASELINE = 4.0  # px from the middle of a label's digits to the foot of its letters
_GAP = 6.0  # px between a label and the plot beside it

#: places in the drawing, px, each with its label
Labels = Iterable[tuple[float, str]]


class Frame(NamedTuple):
    """The scales of a plot, across and up."""

    across: Scale
    up: Scale

    def x(self, value: float) -> float:
        """Return the place of a value from left to right, px."""
        return self.across.place(value)

    def y(self, value: float) -> float:
        """Return the place of a value from top to bottom, px."""
        return self.up.place(value)


def words(x: float, y: float, text: object, css: str = "") -> str:
    """Return a line of text whose foot is at y, px; `css` is its class in the style sheet."""
    kind = f' class="{css}"' if css else ""
    return f'<text{kind} x="{x:.1f}" y="{y:.1f}">{html.escape(str(text))}</text>'


def columns(labels: Labels, top: float, bottom: float, foot: float, css: str = "c") -> str:
    """Return lines from top to bottom at some places, each with a label whose foot is at `foot`, px."""
    return "".join(
        f'<path class="g" d="M{x:.1f} {top:g}V{bottom:g}"/>{words(x, foot, label, css)}' for x, label in labels
    )


def rows(labels: Labels, left: float, right: float, css: str = "r") -> str:
    """Return lines from left to right at some places, each with a label before it."""
    return "".join(
        f'<path class="g" d="M{left:g} {y:.1f}H{right:g}"/>{words(left - _GAP, y + BASELINE, label, css)}'
        for y, label in labels
    )
