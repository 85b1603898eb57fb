"""A drawing as SVG."""

from __future__ import annotations

import base64
import html
from functools import singledispatch

from stretch_bt.simulation.picture.drawing import Array, Drawing, Picture, Polygon, Polyline, Shape, Text
from stretch_bt.simulation.picture.raster import encode_png

__all__ = ["to_svg"]


def to_svg(drawing: Drawing) -> str:
    """Return the text of an SVG file that stands alone."""
    size = f'viewBox="0 0 {drawing.width:g} {drawing.height:g}" width="{drawing.width:g}" height="{drawing.height:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}><title>{html.escape(drawing.title)}</title>'
    style = "<style>text{font-family:sans-serif}image{image-rendering:pixelated}</style>"
    ground = '<rect width="100%" height="100%" fill="#ffffff"/>'
    return f"{head}{style}{ground}{''.join(map(_written, drawing.shapes))}</svg>\n"


@singledispatch
def _written(shape: Shape) -> str:
    raise TypeError(type(shape))


@_written.register
def _(shape: Polygon) -> str:
    return f'<polygon points="{_places(shape.points)}" fill="{shape.fill}"/>'


@_written.register
def _(shape: Polyline) -> str:
    dashes = ' stroke-dasharray="5 4"' if shape.dashed else ""
    look = f'fill="none" stroke="{shape.color}" stroke-width="{shape.width:g}"{dashes}'
    return f'<polyline points="{_places(shape.points)}" {look}/>'


@_written.register
def _(shape: Text) -> str:
    look = f'font-size="{shape.size:g}" text-anchor="{shape.anchor}" fill="{shape.color}"'
    return f'<text x="{shape.x:.1f}" y="{shape.y:.1f}" {look}>{html.escape(shape.text)}</text>'


@_written.register
def _(shape: Picture) -> str:
    where = f'x="{shape.x:.1f}" y="{shape.y:.1f}" width="{shape.width:.1f}" height="{shape.height:.1f}"'
    data = base64.b64encode(encode_png(shape.image)).decode()
    return f'<image {where} preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'


def _places(points: Array) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in points)
