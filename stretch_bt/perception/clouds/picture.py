"""A picture of a cloud: from above, from the front and from the right, coloured by standard deviation."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.arguments import check_kind
from stretch_bt.perception.clouds.cloud import Array, Cloud
from stretch_bt.perception.clouds.ply import colours
from stretch_bt.perception.types import CLOUD

__all__ = ["draw_cloud", "encode"]

Image = npt.NDArray[np.uint8]

_PANEL, _MARGIN, _HEAD, _FOOT = 440, 40, 60, 60
#: heading, axis to the right, axis upwards, axis towards the viewer, and the sign of that one
_VIEWS = (("from above", 0, 1, 2, 1), ("from the front", 0, 2, 1, -1), ("from the right", 1, 2, 0, 1))
_INK = (60, 60, 60)


def draw_cloud(cloud: Cloud) -> Image:
    """Return an (h, w, 3) uint8 picture, channels blue, green, red: three views of one scale, with a bar for it."""
    check_kind("cloud", cloud, Cloud, CLOUD)
    image = np.full((_HEAD + _PANEL + _FOOT, 3 * _PANEL, 3), 255, np.uint8)
    scale = _scale(cloud.points)
    for number, (heading, right, up, near, sign) in enumerate(_VIEWS):
        panel = image[_HEAD : _HEAD + _PANEL, number * _PANEL : (number + 1) * _PANEL]
        order = np.argsort(sign * cloud.points[:, near], kind="stable")
        _dots(panel, cloud.points[order][:, [right, up]], colours(cloud.sd)[order][:, ::-1], scale)
        _write(image, f"{heading}: {'xyz'[right]} right, {'xyz'[up]} up", number * _PANEL + 16, _HEAD - 14)
    _write(image, _caption(cloud), 16, 24)
    _bar(image, scale)
    return image


def encode(cloud: Cloud) -> bytes:
    """Return the picture as the bytes of a PNG file."""
    import cv2

    return bytes(cv2.imencode(".png", draw_cloud(cloud))[1].tobytes())


def _scale(points: Array) -> float:
    """Return pixels per metre."""
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    return (_PANEL - 2 * _MARGIN) / max(size, 1e-4)


def _dots(panel: Any, places: Array, shades: Image, scale: float) -> None:
    """Draw each point as a square as wide as its neighbours are apart, the nearest last."""
    if not len(places):
        return
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    at = np.rint((places - middle) * scale * [1, -1] + _PANEL / 2).astype(int)
    for du in range(-1, 2):
        for dv in range(-1, 2):
            panel[at[:, 1] + dv, at[:, 0] + du] = shades


def _caption(cloud: Cloud) -> str:
    if not len(cloud):
        return "no points"
    sd = cloud.sd * 1e3
    return (
        f"{len(cloud)} points of {cloud.contacts} contacts, frame of the {cloud.frame}; "
        f"standard deviation {sd.min():.2g} (blue) to {sd.max():.2g} mm (red)"
    )


def _bar(image: Any, scale: float) -> None:
    """Draw a bar of 1, 2 or 5 times a power of ten millimetres."""
    import cv2

    most = 0.3 * _PANEL / scale * 1e3
    power = 10.0 ** np.floor(np.log10(most))
    length = max(step * power for step in (1, 2, 5) if step * power <= most)
    left, base = 16, _HEAD + _PANEL + _FOOT // 2
    cv2.line(image, (left, base), (left + round(length * scale / 1e3), base), _INK, 3)
    _write(image, f"{length:g} mm", left, base + 22)


def _write(image: Any, text: str, x: int, y: int) -> None:
    import cv2

    cv2.putText(image, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.5, _INK, 1, cv2.LINE_AA)
