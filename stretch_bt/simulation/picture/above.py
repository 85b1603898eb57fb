"""The membrane from above: its height, and where it touches."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.frames import Intrinsics
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.picture.colors import CONTACT, shades, to_rgb
from stretch_bt.simulation.picture.drawing import Array, Drawing, Picture, Text
from stretch_bt.simulation.picture.panel import LEFT, PanelScale, color_bar, new_panel, scale_bar
from stretch_bt.simulation.picture.stage import Moment

__all__ = ["draw_above", "height_map"]

_FAR = 10.0  # m; from there nearer things look no larger
_PITCH = 0.4e-3  # m, of a pixel
_MARGIN = 0.004
_TOUCHING = 0.02e-3  # m between membrane and body

Mask = npt.NDArray[np.bool_]


def draw_above(moment: Moment) -> Drawing:
    """Return the panel."""
    panel = new_panel("pressed membrane, from above" if not moment.refusal else "free membrane, from above")
    height, x, y = height_map(moment)
    there = np.isfinite(height)
    low, high = float(height[there].min()), float(height[there].max())
    image = shades(height, low, high)
    touching = _touching(moment, height, x, y)
    image[touching] = (0.35 * image[touching] + 0.65 * to_rgb(CONTACT)).astype(np.uint8)
    image[~there] = 255
    frame = PanelScale((x[0], -y[-1]), (x[-1], -y[0]))
    (x0, y0), (x1, y1) = frame.at(np.array([(x[0], -y[0]), (x[-1], -y[-1])]))
    panel.add(Picture(x0, y0, x1 - x0, y1 - y0, image))
    area = float(touching.sum()) * _PITCH**2
    panel.add(Text(LEFT, 38, f"stretch up and down; contact {area * 1e6:.3g} mm2 in red", size=11))
    scale_bar(panel, frame.scale)
    color_bar(panel, low, high, "high")
    return panel


def height_map(moment: Moment) -> tuple[Array, Array, Array]:
    """Return height (rows, columns), m, NaN beside the membrane, and the places x of its columns and y of its rows, m."""
    membrane = moment.world.membrane
    ends = moment.skin.ends
    half = membrane.width / 2 + _MARGIN, max(abs(e) for e in ends) + _MARGIN
    columns, rows = (2 * round(h / _PITCH) + 1 for h in half)
    lens = Intrinsics(_FAR / _PITCH, _FAR / _PITCH, columns // 2, rows // 2, columns, rows)
    depth = DepthRenderer(lens, _FAR).render(moment.skin).astype(float)
    height = np.where(depth > 0, _FAR - depth, np.nan)
    x, y = ((np.arange(count, dtype=float) - count // 2) * _PITCH for count in (columns, rows))
    return height, x, y


def _touching(moment: Moment, height: Array, x: Array, y: Array) -> Mask:
    """Return where the membrane touches the body."""
    from stretch_bt.simulation.membrane.indenters.placed import place
    from stretch_bt.simulation.membrane.indenters.turned import turn

    there: Mask = np.isfinite(height)
    where = moment.contact.place
    if where is None or moment.contact.depth <= 0:
        return np.zeros_like(there)
    if where.body is None:
        return there
    across, along = np.meshgrid(x, y)
    points: Any = np.column_stack([across[there], along[there], height[there]])
    bodies = place(turn(where.body, where.heading), where.at, where.tilt, moment.contact.depth)
    found = np.zeros_like(there)
    found[there] = np.min([body.gap(points).distance for body in bodies], axis=0) < _TOUCHING
    return found
