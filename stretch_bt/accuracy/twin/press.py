"""One press of what a scene holds, measured as the paper's reconstruction and characterisation do."""

from __future__ import annotations

from stretch_bt.accuracy.twin.cell import Bench
from stretch_bt.errors import NoAnswer
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.perception import deproject, diameters, find_contact, to_membrane, track_height
from stretch_bt.simulation.scene import Scene

__all__ = ["height_of", "press_once"]

_CLEAR = 0.004  # m above the top where a press begins
_SPEED = 0.005  # m/s
_READINGS = 20


def press_once(scene: Scene, seed: int) -> dict[str, float]:
    """Return the height of the top, m, the mean width of the contact, m, and the force, N, of a press."""
    bench, use = Bench(scene, seed), scene.conditions
    place = scene.object.position
    above = Pose((place.x, place.y, scene.object.top + _CLEAR))
    bench.stretch(use.stretch)
    bench.go(above, 0.1)
    bench.go(above.at_height(scene.object.top - use.depth), _SPEED)
    bench.time += use.hold / 2
    frame = bench.frame(use.frames)
    found = {"height": height_of(frame), "force": bench.force(_READINGS)}
    try:
        contact = find_contact(frame)
        points, _ = deproject(frame)
        widths = diameters(to_membrane(points, frame.plane_distance or 0.0), contact.labels)
    except NoAnswer:
        return found
    return {**found, "size": (float(widths.i) + float(widths.j)) / 2}


def height_of(frame: DepthFrame) -> float:
    """Return the world height of the top, m."""
    contact = find_contact(frame)
    points, valid = deproject(frame)
    top = track_height(to_membrane(points, frame.plane_distance or 0.0), valid, contact.labels)
    return float(top) + (frame.hand_height or 0.0)
