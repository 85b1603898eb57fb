"""A scene in three panels: a cut through it, the pressed membrane, and the frame that the camera sends."""

from __future__ import annotations

from pathlib import Path

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.picture.above import draw_above
from stretch_bt.simulation.picture.drawing import Drawing, Text
from stretch_bt.simulation.picture.frame import draw_frame
from stretch_bt.simulation.picture.panel import HEIGHT, WIDTH
from stretch_bt.simulation.picture.raster import encode_png, to_image
from stretch_bt.simulation.picture.side import draw_side
from stretch_bt.simulation.picture.stage import Moment, Stage, act
from stretch_bt.simulation.picture.svg import to_svg
from stretch_bt.simulation.scene import Scene

__all__ = ["draw_scene", "save_scene"]

_HEAD, _LINE, _LETTERS = 30.0, 17.0, 190
ENDINGS = (".svg", ".png")


def draw_scene(moment: Moment) -> Drawing:
    """Return the picture."""
    scene, lines = moment.scene, _effects(moment)
    picture = Drawing(3 * WIDTH, _HEAD + HEIGHT + _LINE * len(lines) + 12, scene.name)
    past = (scene.object.top - moment.pose.height) * 1e3
    what = f"stretch {scene.conditions.stretch * 1e3:g} mm, hand {max(past, 0.0):.4g} mm below the object's top"
    picture.add(Text(16, 24, f"{scene.name}: {scene.fidelity} fidelity, {what}", size=15))
    for k, panel in enumerate((draw_side(moment), draw_above(moment), draw_frame(moment))):
        picture.place(panel.shapes, k * WIDTH, _HEAD)
    picture.add(*(Text(16, _HEAD + HEIGHT + _LINE * (k + 0.6), line) for k, line in enumerate(lines)))
    return picture


def save_scene(scene: Scene, path: Path, stage: Stage | None = None) -> Moment:
    """Draw a scene into a file whose ending, .svg or .png, chooses the format, and return the moment drawn.

    Raises
    ------
    InvalidInput
        The ending is another one, or the file cannot be written.
    """
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InvalidInput(
            f"{path.name!r} does not end in {' or '.join(ENDINGS)}; write a name such as {scene.name}.svg"
        )
    moment = act(scene, stage or Stage())
    drawing = draw_scene(moment)
    data = to_svg(drawing).encode() if ending == ".svg" else encode_png(to_image(drawing))
    try:
        path.write_bytes(data)
    except OSError as error:
        raise InvalidInput(f"the picture cannot be written to {path}: {error.strerror}") from error
    return moment


def _effects(moment: Moment) -> list[str]:
    """Return the effects that are on, in lines."""
    lines = ["effects on: "]
    for name in [effect.name for effect in moment.world.effects] or ["none"]:
        if len(lines[-1]) + len(name) > _LETTERS:
            lines.append("")
        lines[-1] += ("" if lines[-1].endswith(": ") or not lines[-1] else ", ") + name
    return lines
