"""A drawing as pixels."""

from __future__ import annotations

from functools import singledispatch
from typing import Any

import numpy as np

from stretch_bt.simulation.picture.drawing import Array, Drawing, Image, Picture, Polygon, Polyline, Shape, Text

__all__ = ["encode_png", "to_image"]

_SCALE = 2  # pixels to a unit of the drawing
_BITS = 4  # of a pixel, in places
_DASH, _HOLE = 5.0, 4.0
_LETTER = 0.0455  # scale of the font to a size of 1


def to_image(drawing: Drawing) -> Image:
    """Return (h, w, 3) uint8, red, green, blue."""
    image = np.full((round(drawing.height * _SCALE), round(drawing.width * _SCALE), 3), 255, np.uint8)
    for shape in drawing.shapes:
        _draw(shape, image)
    return image


def encode_png(image: Image) -> bytes:
    """Return an image, red, green, blue, as the bytes of a PNG file."""
    import cv2

    return bytes(cv2.imencode(".png", image[..., ::-1])[1].tobytes())


@singledispatch
def _draw(shape: Shape, image: Any) -> None:
    raise TypeError(type(shape))


@_draw.register
def _(shape: Polygon, image: Any) -> None:
    import cv2

    cv2.fillPoly(image, [_pixels(shape.points)], _color(shape.fill), cv2.LINE_AA, _BITS)


@_draw.register
def _(shape: Polyline, image: Any) -> None:
    import cv2

    pieces = _dashes(shape.points) if shape.dashed else [shape.points]
    width = max(round(shape.width * _SCALE), 1)
    cv2.polylines(image, [_pixels(p) for p in pieces], False, _color(shape.color), width, cv2.LINE_AA, _BITS)


@_draw.register
def _(shape: Text, image: Any) -> None:
    import cv2

    scale = _LETTER * shape.size * _SCALE / 1.3
    (width, _), _ = cv2.getTextSize(shape.text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    x = shape.x * _SCALE - {"start": 0.0, "middle": width / 2, "end": width}[shape.anchor]
    at = (round(x), round(shape.y * _SCALE))
    cv2.putText(image, shape.text, at, cv2.FONT_HERSHEY_SIMPLEX, scale, _color(shape.color), 1, cv2.LINE_AA)


@_draw.register
def _(shape: Picture, image: Any) -> None:
    import cv2

    x0, y0 = round(shape.x * _SCALE), round(shape.y * _SCALE)
    x1, y1 = round((shape.x + shape.width) * _SCALE), round((shape.y + shape.height) * _SCALE)
    image[y0:y1, x0:x1] = cv2.resize(shape.image, (x1 - x0, y1 - y0), interpolation=cv2.INTER_NEAREST)


def _pixels(points: Array) -> Any:
    return np.rint(points * _SCALE * (1 << _BITS)).astype(np.int32)


def _color(text: str) -> tuple[int, int, int]:
    red, green, blue = bytes.fromhex(text[1:])
    return red, green, blue


def _dashes(points: Array) -> list[Array]:
    """Return the pieces of a line that are drawn."""
    way = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    pieces = []
    for begin in np.arange(0.0, way[-1], _DASH + _HOLE):
        at = np.array([begin, *way[(way > begin) & (way < begin + _DASH)], min(begin + _DASH, way[-1])])
        pieces.append(np.column_stack([np.interp(at, way, points[:, k]) for k in (0, 1)]))
    return pieces
