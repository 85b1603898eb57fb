"""The advisor's estimate of bending against sheets solved with it and without."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.advisor.case import Case
from stretch_bt.simulation.dough.surface import disc_side
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


@pytest.mark.parametrize(("edge", "stress"), [(20.8, 8763), (27.6, 9100), (28.1, 2071)])
def test_dough_that_is_pressed_flat_lifts_the_sheet_as_its_estimate_has_it(edge, stress):
    """It was held for a dome for good, so that hard dough was pressed by a sheet that does not bend, and read 0.3 mm too thin."""
    scene = parse_scene(
        f"format: stretch-scene/1\nobject: {{type: dough, edge: {edge} mm, yield_stress: {stress} Pa, modulus: {20 * stress} Pa}}\n"
        "tolerance: {height: 0.5 mm}\nconditions: {stretch: 0 mm, depth: 11 mm}\n"
    )
    assert next(v for v in advise(scene) if v.name == "bending").on
    told = max(
        size.value for size in Bending.sizes(Case(scene, scene.object.rough()), None) if size.observable == "height"
    )
    height, angles = 0.65e-3 * edge, np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    radius = 0.6 * height + np.sqrt((1e-3 * edge) ** 3 / height / np.pi)
    disc = disc_side(radius * np.column_stack([np.cos(angles), np.sin(angles)]), height, scene.object.ball)
    assert 1 / 1.5 < told / bending.changes(scene, disc)["height"] < 1.5


@pytest.mark.parametrize("scene", scene_names())
def test_the_sheet_bends_in_every_shipped_scene(scene):
    assert next(v for v in advise(load_scene(scene)) if v.name == "bending").on
