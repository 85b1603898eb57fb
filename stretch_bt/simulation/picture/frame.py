"""The depth frame as the camera sends it."""

from __future__ import annotations

import numpy as np

from stretch_bt.simulation.picture.colors import INVALID, shades, to_rgb
from stretch_bt.simulation.picture.drawing import Drawing, Picture, Text
from stretch_bt.simulation.picture.panel import LEFT, PanelScale, color_bar, new_panel, scale_bar
from stretch_bt.simulation.picture.stage import Moment

__all__ = ["draw_frame"]

_BEHIND = 0.004  # m behind the flat membrane, up to which shades distinguish depths


def draw_frame(moment: Moment) -> Drawing:
    """Return the panel."""
    panel, frame = new_panel("depth frame"), moment.frame
    if frame is None:
        panel.add(Text(LEFT, 60, "there is none"))
        return panel
    depth = frame.depth
    plane, valid = frame.plane_distance or 0.0, depth > 0
    nearest = float(np.percentile(depth[valid], 0.5)) if valid.any() else plane
    low, high = min(nearest, plane), plane + _BEHIND
    image = shades(-depth, -high, -low)
    image[~valid] = to_rgb(INVALID)
    half = (frame.intrinsics.width / 2, frame.intrinsics.height / 2)
    pixels = PanelScale((-half[0], -half[1]), half)
    (x0, y0), (x1, y1) = pixels.at(np.array([(-half[0], half[1]), (half[0], -half[1])]))
    panel.add(Picture(x0, y0, x1 - x0, y1 - y0, image))
    size = f"{frame.intrinsics.width} x {frame.intrinsics.height} pixels, counts of {frame.unit * 1e3:.3g} mm"
    panel.add(Text(LEFT, 38, f"{size}, {np.mean(~valid):.1%} without a value (magenta)", size=11))
    scale_bar(panel, pixels.scale * frame.intrinsics.fx / plane)
    color_bar(panel, high, low, "deep")
    return panel
