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
from stretch_bt.runtime.report.panels.looks import written
from stretch_bt.runtime.report.text import escape, section

__all__ = ["panel"]

Array = npt.NDArray[np.float64]

NOTE = (
    "from above: points that were felt (grey), the fitted {} (blue, dashed), and the outline of what the scene has there, as far as "
    "a press from above may feel it (green)"
)
SIZE, MARGIN = 440, 20
MOST = 4000  # points drawn
CELL = 5e-4  # m, of the true outline
ROUND = np.linspace(0.0, 2 * np.pi, 73)


def panel(record: RecordReader) -> str:
    """Return the panel of a run that fitted a shape; nothing where it did not."""
    kind, x, y = _kind(record), *(written(record.events, f"solid_{name}") for name in "xy")
    path = record.folder / "cloud.ply"
    if not kind or x is None or y is None or not path.exists():
        return ""
    from stretch_bt.perception.clouds.ply import points_of

    sizes = {name: written(record.events, name) for name in ("length", "width", "radius", "side", "solid_heading")}
    fitted = [line + np.array([x, y]) for line in _fitted(kind, {k: v for k, v in sizes.items() if v is not None})]
    felt = points_of(path.read_bytes())[:, :2]
    return section("Shape", _drawing(felt, fitted, _truth(record)), NOTE.format(escape(kind.replace("_", " "))))


def _kind(record: RecordReader) -> str:
    found = [e["value"] for e in record.events if e["type"] == "write" and e["key"] == "main/shape"]
    return found[-1] if found and isinstance(found[-1], str) else ""


def _fitted(kind: str, sizes: dict[str, float]) -> list[Array]:
    """Return the lines (n, 2), m, of a shape from above, about the middle of its top."""
    turn = sizes.get("solid_heading", 0.0)
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
