"""Depth frames as small colour-mapped pictures within the page."""

from __future__ import annotations

import base64

import numpy as np

from stretch_bt.frames import DepthFrame
from stretch_bt.runtime.report.history import Frames
from stretch_bt.runtime.report.text import escape, number, seconds

__all__ = ["pictures"]

WIDTH = 320  # px


def pictures(cameras: dict[str, Frames]) -> str:
    """Return the first and last frame of each camera; both share one range of colours."""
    return "".join(_pair(device, frames) for device, frames in cameras.items())


def _pair(device: str, frames: Frames) -> str:
    low, high = _range(frames)
    return _figure(device, "first", *frames.first, low, high) + _figure(device, "last", *frames.last, low, high)


def _range(frames: Frames) -> tuple[float, float]:
    """Return the depths, m, between which 98 % of the valid pixels lie."""
    depths = np.concatenate([frame.depth[frame.raw > 0] for _, frame in (frames.first, frames.last)])
    if depths.size == 0:
        return 0.0, 1.0
    low, high = np.percentile(depths, (1, 99))
    return float(low), float(max(high, low + 1e-4))


def _figure(device: str, which: str, time: float, frame: DepthFrame, low: float, high: float) -> str:
    valid = f"{np.mean(frame.raw > 0):.1%} valid"
    caption = f"<b>{escape(device)}</b> <span>{which} frame, {seconds(time)} s, {valid}</span>"
    caption += f"<em>{number(low * 1e3)} to {number(high * 1e3)} mm</em>"
    return f'<figure><figcaption>{caption}</figcaption><img alt="depth" src="{_picture(frame, low, high)}"></figure>'


def _picture(frame: DepthFrame, low: float, high: float) -> str:
    import cv2

    shown = np.clip((frame.depth - low) / (high - low) * 255, 0, 255).astype(np.uint8)
    coloured = cv2.applyColorMap(255 - shown, cv2.COLORMAP_VIRIDIS)
    coloured[frame.raw == 0] = 160
    height, width = frame.raw.shape
    if width > WIDTH:
        coloured = cv2.resize(coloured, (WIDTH, round(height * WIDTH / width)), interpolation=cv2.INTER_AREA)
    _, png = cv2.imencode(".png", coloured)
    return "data:image/png;base64," + base64.b64encode(png.tobytes()).decode()
