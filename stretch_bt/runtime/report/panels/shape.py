"""Reconstruction: the shape that was fitted, over the points that were felt and the outline that the scene knows."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import StretchError
from stretch_bt.runtime.copies import copy_of
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.report.panels.keys import Key, finite
from stretch_bt.runtime.report.text import escape, section

__all__ = ["panel"]

Array = npt.NDArray[np.float64]

NOTE = (
    "from above: points that were felt (grey), the fitted {} (blue, dashed), and the outline of what the scene has there, as far as "
    "a press from above may feel it (green)"
)
SOLID = Key("main/solid", ("reconstruct",), ("kind", "dimensions", "x", "y", "heading"))
SIZE, MARGIN = 440, 20
MOST = 4000  # points drawn
CELL = 5e-4  # m, of the true outline
ROUND = np.linspace(0.0, 2 * np.pi, 73)


def panel(record: RecordReader) -> str:
    """Return the panel of a run that fitted a shape; nothing where it did not."""
    solid, path = SOLID.last(record.events), record.folder / "cloud.ply"
    told = solid if isinstance(solid, dict) and path.exists() else {}
    kind, x, y = told.get("kind"), finite(told.get("x")), finite(told.get("y"))
    if not isinstance(kind, str) or x is None or y is None:  # older records do not say where it stands, nor need mocks
        return ""
    from stretch_bt.perception.clouds.ply import points_of

    fitted = [line + np.array([x, y]) for line in _fitted(kind, _sizes(told), finite(told.get("heading")) or 0.0)]
    felt = points_of(path.read_bytes())[:, :2]
    return section("Shape", _drawing(felt, fitted, _truth(record)), NOTE.format(escape(kind.replace("_", " "))))


def _sizes(solid: dict[str, Any]) -> dict[str, float]:
    """Return the dimensions that a shape has, m."""
    dimensions = solid.get("dimensions")
    given = dimensions.items() if isinstance(dimensions, dict) else ()
    values = {name: finite(told.get("value")) for name, told in given if isinstance(told, dict)}
    return {name: value for name, value in values.items() if value is not None}


def _fitted(kind: str, sizes: dict[str, float], turn: float) -> list[Array]:
    """Return the lines (n, 2), m, of a shape from above that is turned by `turn`, rad, about the middle of its top."""
    if kind == "wire_triangle":
        corners = turn + np.pi / 3 + np.arange(4) * 2 * np.pi / 3
        return [sizes.get("side", 0.0) / math.sqrt(3) * np.column_stack([np.cos(corners), np.sin(corners)])]
    if kind in ("disc", "domes", "wire_circle"):
        return [sizes.get("radius", 0.0) * np.column_stack([np.cos(ROUND), np.sin(ROUND)])]
    length, width = sizes.get("length", 0.0) / 2, sizes.get("width", 2 * sizes.get("radius", 0.0)) / 2
    c, s = math.cos(turn), math.sin(turn)
    box = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * [max(length, 1e-3), max(width, 2e-4)]
    return [box @ np.array([[c, s], [-s, c]])]


def _truth(record: RecordReader) -> list[Array]:
    """Return the outlines (n, 2), m, of the upper surface of the scene's object; none where it has no such surface, or a real camera looked."""
    scene, text = (record.run_info.get(name) for name in ("scene", "scene_text"))
    if not scene or "DepthCamera" not in record.run_info.get("simulated", ["DepthCamera"]):
        return []
    from stretch_bt.simulation.above import upper_surface
    from stretch_bt.simulation.scene import load_scene, parse_scene

    with suppress(StretchError):
        made = parse_scene(text, copy_of(scene)) if isinstance(text, str) else load_scene(scene)
        return _outlines(upper_surface(made.object, CELL).places)
    return []


def _outlines(places: Array) -> list[Array]:
    import cv2

    low = places.min(axis=0) - 2 * CELL
    cells = np.rint((places - low) / CELL).astype(int)
    mask = np.zeros(cells.max(axis=0) + 3, np.uint8)
    mask[tuple(cells.T)] = 1
    found: Any = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    return [np.vstack([line, line[:1]])[:, 0, ::-1] * CELL + low for line in found if len(line) > 8]


def _drawing(felt: Array, fitted: list[Array], truth: list[Array]) -> str:
    every = np.concatenate([felt, *fitted, *truth])
    low, high = every.min(axis=0), every.max(axis=0)
    scale = (SIZE - 2 * MARGIN) / max(float((high - low).max()), 1e-3)
    middle = (low + high) / 2

    def place(points: Array) -> Array:
        return np.asarray((points - middle) * scale * [1, -1] + SIZE / 2)

    def lines(shapes: list[Array], style: str) -> str:
        return "".join(
            f'<path d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in place(shape))}" fill="none" style="{style}"/>'
            for shape in shapes
        )

    dots = place(felt[:: max(1, len(felt) // MOST)])
    grey = "".join(f"M{x:.1f} {y:.1f}h1" for x, y in dots)
    bar = f'<path d="M{MARGIN} {SIZE - 6}h{0.01 * scale:.1f}" stroke="#333" stroke-width="2"/>'
    bar += f'<text x="{MARGIN}" y="{SIZE - 12}">10 mm</text>'
    return (
        f'<svg viewBox="0 0 {SIZE} {SIZE}" style="max-width:{SIZE}px"><path d="{grey}" stroke="#b9c0ca"/>'
        + lines(truth, "stroke:#2a8f4d;stroke-width:1.5")
        + lines(fitted, "stroke:#2155a0;stroke-width:2;stroke-dasharray:6 3")
        + bar
        + "</svg>"
    )
