"""A picture of the deformed sheet and where it touches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.membrane.sheet.result import SheetPress

__all__ = ["check_picture", "draw_press", "save_press"]

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.uint8]

_SIZE = (900, 1200)
_SUPER = 2  # drawn larger and reduced, which smooths edges
_LINES = 97
_TURN, _LEAN = np.radians(-35.0), np.radians(58.0)
_LOW, _HIGH, _TOUCH = (np.array(c, float) for c in ((205, 182, 160), (120, 82, 40), (60, 60, 225)))  # blue, green, red
_LIGHT = np.array([-0.35, 0.25, 0.9])


def draw_press(pressed: SheetPress) -> Image:
    """Return a (900, 1200, 3) uint8 picture, channels blue, green, red: shaded by height, the contact in red."""
    import cv2

    points = pressed.shape.points(_LINES, _LINES)
    corners = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 3)
    screen, near = _project(points.reshape(-1, 3))
    flat = _fit(screen).reshape(_LINES, _LINES, 2)
    near = near.reshape(_LINES, _LINES)
    quads = np.stack([flat[:-1, :-1], flat[:-1, 1:], flat[1:, 1:], flat[1:, :-1]], axis=2).reshape(-1, 4, 2)
    order = np.argsort((near[:-1, :-1] + near[1:, 1:]).ravel())
    colours = _colours(pressed, corners)
    image: Any = np.full((_SIZE[0] * _SUPER, _SIZE[1] * _SUPER, 3), 255, np.uint8)
    for k in order:
        cv2.fillConvexPoly(image, np.rint(quads[k] * 16).astype(np.int32), colours[k].tolist(), cv2.LINE_AA, 4)
    for lines in (flat[::8], flat[:, ::8].transpose(1, 0, 2)):
        cv2.polylines(
            image,
            [np.ascontiguousarray(line, np.int32) for line in np.rint(lines * 16)],
            False,
            (150, 132, 118),
            1,
            cv2.LINE_AA,
            4,
        )
    small: Any = cv2.resize(image, (_SIZE[1], _SIZE[0]), interpolation=cv2.INTER_AREA)
    for row, text in enumerate(_captions(pressed)):
        cv2.putText(small, text, (28, 44 + 30 * row), cv2.FONT_HERSHEY_SIMPLEX, 0.66, (60, 60, 60), 1, cv2.LINE_AA)
    return np.asarray(small, np.uint8)


def save_press(pressed: SheetPress, path: str | Path) -> None:
    """Write the picture of a press; the ending of the path chooses the format, such as .png.

    Raises
    ------
    InvalidInput
        The ending names no picture format, or the file cannot be written.
    """
    import cv2

    target = check_picture(path)
    _, data = cv2.imencode(target.suffix, draw_press(pressed))
    try:
        target.write_bytes(data.tobytes())
    except OSError as error:
        raise InvalidInput(f"the picture cannot be written to {target}: {error.strerror}") from error


def check_picture(path: str | Path) -> Path:
    """Return the path of a picture that could be written; raises InvalidInput for one that could not, whatever is drawn."""
    import cv2

    target = Path(path)
    if not cv2.haveImageWriter(target.name):
        raise InvalidInput(f"{target.name!r} does not end in a picture format; write a name such as press.png")
    if not target.parent.is_dir():
        raise InvalidInput(f"there is no folder {target.parent}; make it first")
    return target


def _project(points: Array) -> tuple[Array, Array]:
    """Return places (n, 2) on the screen, right and down, and how near each is to the viewer."""
    c, s = np.cos(_TURN), np.sin(_TURN)
    x, y, z = c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1], points[:, 2]
    up = y * np.cos(_LEAN) + z * np.sin(_LEAN)
    return np.column_stack([x, -up]), z * np.cos(_LEAN) - y * np.sin(_LEAN)


def _fit(screen: Array) -> Array:
    """Return places in pixels that fill the picture below its captions."""
    room = np.array([_SIZE[1] * 0.9, _SIZE[0] * 0.72]) * _SUPER
    low, high = screen.min(axis=0), screen.max(axis=0)
    middle = np.array([_SIZE[1] * 0.5, _SIZE[0] * 0.58]) * _SUPER
    return np.asarray((screen - (low + high) / 2) * (room / (high - low)).min() + middle)


def _colours(pressed: SheetPress, corners: Array) -> Array:
    """Return a colour (n, 3) for each facet, 0 to 255."""
    middle = np.ascontiguousarray(corners.mean(axis=1))
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    shade = 0.72 + 0.28 * np.clip(normal @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)
    height = np.clip(middle[:, 2] / pressed.load.depth, 0, 1)[:, None]
    colour = _LOW + (_HIGH - _LOW) * height
    for contact in pressed.contacts:
        reach = (contact.offset + 0.02) * pressed.shape.unit
        colour[contact.body.gap(middle).distance < reach] = _TOUCH
    return np.asarray(np.clip(colour * shade[:, None], 0, 255))


def _captions(pressed: SheetPress) -> list[str]:
    load = pressed.load
    stretch, depth = load.stretch * 1e3, load.depth * 1e3
    area = pressed.region().area * 1e6
    return [
        f"{type(load.indenter).__name__.lower()}, stretch {stretch:.3g} mm, depth {depth:.3g} mm",
        f"force {pressed.force[2]:.4g} N, error {pressed.force_error:.2g} N; contact {area:.3g} mm2",
    ]
