"""Estimates against the twin with everything on, and with everything on but one effect, at the end of the range of a scene's numbers."""

import math

import pytest

from stretch_bt.accuracy.twin.press_tasks import apart, possible, pressed, scene_with
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.advisor.choose import judge
from stretch_bt.simulation.scene import parse_scene

HEAD = "format: stretch-scene/1\ntolerance: {height: 0.3 mm, size: 1 mm, force: 3 %}\n"
BALL = "object: {type: sphere, diameter: 40 mm, rigid: true}\n"
SLACK = f"{BALL}hand: {{mount_prestretch: 0 mm}}\nconditions: {{stretch: 0 mm, depth: %g mm}}\n"
POST = "{type: box, length: 10 mm, width: 10 mm, height: 30 mm, rigid: true, position: {x: %g mm, y: %g mm}}"
#: by name: a scene, and what each effect changes by more than a tenth of the tolerance in it
SCENES = {
    "slack": (SLACK % 8, {"bending": ("force",), "wrinkling": ("force", "size")}),
    "slack and shallow": (SLACK % 4, {"bending": ("force", "size"), "wrinkling": ("force",)}),
    "long": (f"{BALL}conditions: {{stretch: 200 mm, depth: 8 mm}}\n", {"bending": ("force", "size")}),
    "long, a crest": (
        "object: {type: half_cylinder, diameter: 40 mm, length: 40 mm, rigid: true}\nconditions: {stretch: 150 mm}\n",
        {"bending": ("force", "size")},
    ),
    "posts": (
        f"object: {{type: several, objects: [{', '.join(POST % at for at in ((-13, -8), (13, 8), (8, -13)))}]}}\n"
        "conditions: {stretch: 0 mm, depth: 6 mm}\n",
        {"bending": ("force",), "friction": ("force",), "sag": ("force",)},
    ),
    "a bridge across": (
        "object: {type: bridge, length: 60 mm, width: 20 mm, height: 40 mm, span: 30 mm, rigid: true}\nconditions: {stretch: 20 mm}\n",
        {"friction": ("force",)},
    ),
    "a bar along": (
        "object: {type: box, length: 64 mm, width: 13 mm, height: 60 mm, heading: 90 deg, rigid: true}\n"
        "conditions: {stretch: 0 mm, depth: 8 mm}\n",
        {"friction": ("force",)},
    ),
    "a crest along": (
        "object: {type: half_cylinder, diameter: 29 mm, length: 29 mm, heading: 80 deg, rigid: true}\nconditions: {stretch: 0 mm}\n",
        {"friction": ("force",)},
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_an_estimate_holds_within_a_factor_of_two_at_the_end_of_a_range(name):
    text, effects = HEAD + SCENES[name][0], SCENES[name][1]
    every, scene = set(possible(text)), parse_scene(text)
    judged, known = judge(scene, Case(scene, scene.object.rough())), pressed(scene_with(text, every), within=0.01)
    for effect, observables in effects.items():
        changed = apart(known, pressed(scene_with(text, every - {effect}), within=0.01))
        for observable in observables:
            told = judged[effect].sizes[observable]
            assert 0.5 < told.value / abs(changed[observable]) < 2, (effect, observable, told, changed)
            assert told.way in (0, math.copysign(1, changed[observable])), (effect, observable)
