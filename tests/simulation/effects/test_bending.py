"""The advisor's estimate of bending against sheets solved with it and without."""

import importlib.util
from pathlib import Path

import pytest

from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.effects.bending import Bending
from stretch_bt.simulation.scene import load_scene, parse_scene, scene_names

_spec = importlib.util.spec_from_file_location("bending", Path(__file__).parents[3] / "benchmarks" / "bending.py")
bending = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(bending)

# what bending changes by more than a tenth of the usual tolerance
BODIES = {
    "cylinder": ("type: cylinder, diameter: 25 mm, height: 60 mm", ("force", "height", "size")),
    "block": ("type: box, length: 40 mm, width: 30 mm, height: 40 mm", ("force", "height", "size")),
    "cone": ("type: cone, angle: 45 deg, height: 40 mm", ("force", "height", "size")),
    "sphere": ("type: sphere, diameter: 40 mm", ("force",)),
    "prism": ("type: prism, length: 50 mm, width: 40 mm, height: 30 mm", ("force", "size")),
}


@pytest.mark.parametrize("name", BODIES)
def test_an_estimate_is_within_half_as_much_again_of_what_bending_changes(name):
    options, observables = BODIES[name]
    scene = parse_scene(f"format: stretch-scene/1\nobject: {{{options}, rigid: true}}\nconditions: {{depth: 10 mm}}\n")
    told = {size.observable: size.value for size in Bending.sizes(Case(scene, scene.object.rough()), None)}
    changed = bending.changes(scene)
    for observable in observables:
        assert 1 / 1.5 < told[observable] / changed[observable] < 1.5, (observable, told, changed)


@pytest.mark.parametrize("scene", scene_names())
def test_the_sheet_bends_in_every_shipped_scene(scene):
    assert next(v for v in advise(load_scene(scene)) if v.name == "bending").on
