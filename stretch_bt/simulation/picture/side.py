"""A cut through scene and hand along the stretch direction, through the object's axis, to scale."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stretch_bt.simulation.camera.skin import Grid, Skin
from stretch_bt.simulation.picture.colors import FAINT, INK, MEMBRANE, OBJECT, SUPPORT, WRONG
from stretch_bt.simulation.picture.drawing import Array, Drawing, Text
from stretch_bt.simulation.picture.panel import HEIGHT, LEFT, PanelScale, new_panel, scale_bar
from stretch_bt.simulation.picture.stage import Moment
from stretch_bt.simulation.scene.sections import Cup

if TYPE_CHECKING:
    from stretch_bt.simulation.membrane.indenters.base import Indenter
    from stretch_bt.simulation.membrane.indenters.several import Several
    from stretch_bt.simulation.objects.base import ObjectSpec

    Body = Indenter | Several | None

__all__ = ["draw_side"]

_FINGER = 0.006  # m, half the height of a drawn finger
_WALL = 0.0015  # m, of a drawn cup
_PITCH = 0.2e-3  # m between the places at which a body is asked for
_LINE = 46  # letters of a reason in a line


def draw_side(moment: Moment) -> Drawing:
    """Return the panel."""
    scene = moment.scene
    panel = new_panel("scene, cut along the stretch")
    free, pressed = (_section(s, p.height) for s, p in ((moment.free, moment.touch), (moment.skin, moment.pose)))
    reach = max(float(np.abs(free[:, 0]).max()) + 0.008, 0.03)
    highest = max(float(free[:, 1].max()), moment.touch.height) + 2 * _FINGER
    frame = PanelScale((-reach, -0.006), (reach, highest))
    _support(panel, frame, moment, reach)
    stands = moment.world.standing(moment.contact.drop)
    for outline in _outlines(scene.object, stands.body, stands.top, reach):
        panel.polygon(frame.at(outline), OBJECT)
    for outline in _outlines(scene.object, scene.object.body(), scene.object.top, reach):
        panel.line(frame.at(np.vstack([outline, outline[:1]])), FAINT, 0.8, dashed=True)
    panel.line(frame.at(free), FAINT, 1.5, dashed=not moment.refusal)
    if not moment.refusal:
        panel.line(frame.at(pressed), MEMBRANE, 2.5)
    for ends in (free, pressed):
        for y, z in ends[[0, -1]]:
            box = [(y - _FINGER / 2, z - _FINGER), (y + _FINGER / 2, z + _FINGER)]
            (x0, y0), (x1, y1) = frame.at(np.array(box))
            panel.box(x0, y0, x1, y1, FAINT if ends is free and not moment.refusal else INK)
    _words(panel, moment)
    scale_bar(panel, frame.scale)
    panel.add(Text(LEFT, 38, f"object {scene.object.type}, top at {scene.object.top * 1e3:.4g} mm", size=11))
    return panel


def _words(panel: Drawing, moment: Moment) -> None:
    if moment.refusal:
        words, lines = moment.refusal.split(), ["nothing is pressed:"]
        for word in words:
            if len(lines[-1]) + len(word) > _LINE:
                lines.append("")
            lines[-1] += f" {word}"
        panel.add(*(Text(LEFT, 60 + 15 * k, line.strip(), color=WRONG) for k, line in enumerate(lines)))
        return
    force = math.hypot(*moment.contact.force)
    told = f"{force:.3g} N, depth {moment.contact.depth * 1e3:.3g} mm, drop {moment.contact.drop * 1e3:.3g} mm"
    panel.add(Text(LEFT + 180, HEIGHT - 12, told, size=11))


def _section(skin: Skin, height: float) -> Array:
    """Return (n, 2), m: y and world z of the membrane over the hand's middle."""
    if isinstance(skin, Grid):
        columns = np.abs(skin.points[..., 0].mean(axis=0))
        y, z = skin.points[:, int(columns.argmin()), 1:].T
    else:
        y = np.linspace(*skin.ends, 401)
        away = np.hypot(y - skin.axis[1], skin.axis[0])
        z = np.zeros_like(y) if skin.surface is None else skin.surface.height(away)
    return np.column_stack([y, z + height])


def _support(panel: Drawing, frame: PanelScale, moment: Moment, reach: float) -> None:
    """Add the table, and a cup or the post of an object that stands above the table."""
    spec, support = moment.scene.object, moment.scene.support
    _box(panel, frame, -reach, -0.006, reach, 0.0)
    if isinstance(support, Cup):
        for side in (-1, 1):
            inner = side * support.diameter / 2
            _box(panel, frame, inner, 0.0, inner + side * _WALL, support.rim)
    elif spec.base > 0:
        half = min(spec.reach, reach) / 4
        _box(panel, frame, -half, 0.0, half, spec.base)


def _box(panel: Drawing, frame: PanelScale, y0: float, z0: float, y1: float, z1: float) -> None:
    corners = frame.at(np.array([(y0, z0), (y1, z1)]))
    (x0, top), (x1, bottom) = corners.tolist()
    panel.box(x0, top, x1, bottom, SUPPORT)


def _outlines(spec: ObjectSpec, body: Body, top: float, reach: float) -> list[Array]:
    """Return the outlines (n, 2), m, y and world z, of the cut of an object whose top is there now."""
    import cv2

    wide = min(spec.reach, reach)
    y = np.arange(-wide - 4 * _PITCH, wide + 4 * _PITCH, _PITCH)
    z = np.arange(spec.base - 2 * _PITCH, spec.top + 2 * _PITCH, _PITCH)
    inside = (_inside(spec, body, top, y, z) & (z >= spec.base)[:, None]).astype(np.uint8)
    inside[:, [0, -1]] = 0
    found: Any = cv2.findContours(inside, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    return [np.array([y[0], z[0]]) + c[:, 0] * _PITCH for c in found if len(c) > 2]


def _inside(spec: ObjectSpec, body: Body, top: float, y: Array, z: Array) -> Any:
    """Return (len(z), len(y)) bool."""
    from stretch_bt.simulation.membrane.indenters.placed import place
    from stretch_bt.simulation.membrane.indenters.sphere import Sphere
    from stretch_bt.simulation.membrane.indenters.turned import turn

    across, up = np.meshgrid(y, z)
    if body is None:
        return up <= top
    if isinstance(body, Sphere):  # for the membrane it goes on downwards as a shank
        radius = body.diameter / 2
        return np.hypot(across, up - top + radius) <= radius
    points = np.column_stack([np.zeros(across.size), across.ravel(), up.ravel()])
    bodies = place(turn(body, -spec.heading), (0.0, 0.0), (0.0, 0.0), top)
    distance = np.min([b.gap(points).distance for b in bodies], axis=0)
    return distance.reshape(across.shape) <= 0
