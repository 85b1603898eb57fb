"""The common part of the panels of a picture: size, heading, scale, bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stretch_bt.draw.scale import round_down
from stretch_bt.simulation.picture.colors import FAINT, INK, shades
from stretch_bt.simulation.picture.drawing import Array, Drawing, Picture, Text

__all__ = ["BOTTOM", "HEIGHT", "LEFT", "TOP", "WIDTH", "PanelScale", "color_bar", "new_panel", "scale_bar"]

WIDTH, HEIGHT = 440.0, 470.0
LEFT, TOP, BOTTOM = 46.0, 50.0, 44.0


def new_panel(heading: str) -> Drawing:
    """Return an empty panel."""
    panel = Drawing(WIDTH, HEIGHT)
    panel.add(Text(LEFT, 22, heading, size=14, color=INK))
    return panel


@dataclass(frozen=True, slots=True)
class PanelScale:
    """Maps lengths, m, to one panel: `scale` in its units a metre, the middle of `low` and `high` (2,) in its middle, up is up."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def scale(self) -> float:
        """Units of the panel for a metre, the same both ways."""
        across, up = self.high[0] - self.low[0], self.high[1] - self.low[1]
        return min((WIDTH - LEFT - 14) / across, (HEIGHT - TOP - BOTTOM) / up)

    def at(self, points: Array) -> Array:
        """Return places (n, 2) in the panel of points (n, 2), m."""
        middle = np.add(self.low, self.high) / 2
        center = np.array([(LEFT + WIDTH - 14) / 2, (TOP + HEIGHT - BOTTOM) / 2])
        return np.asarray(center + (np.asarray(points, float) - middle) * self.scale * [1, -1])


def scale_bar(panel: Drawing, scale: float) -> None:
    """Add a bar of a round length below; `scale` in units a metre."""
    length = round_down(110 / scale)
    y = HEIGHT - 16
    panel.line([(LEFT, y), (LEFT + length * scale, y)], INK, 3)
    panel.add(Text(LEFT + length * scale + 8, y + 4, f"{length * 1e3:g} mm", color=INK))


def color_bar(panel: Drawing, low: float, high: float, what: str) -> None:
    """Add a scale of the shades, m, below to the right."""
    x, y, width = WIDTH - 190, HEIGHT - 22, 80.0
    image = np.repeat(shades(np.linspace(0, 1, 64), 0, 1)[None], 2, axis=0)
    panel.add(Picture(x, y, width, 9, image))
    panel.line([(x, y), (x + width, y), (x + width, y + 9), (x, y + 9), (x, y)], FAINT, 0.5)
    panel.add(
        Text(x - 6, y + 9, f"{low * 1e3:.3g}" if abs(low) > 1e-5 else "0", "end"),
        Text(x + width + 6, y + 9, f"{high * 1e3:.3g} mm {what}"),
    )
