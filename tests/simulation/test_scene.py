from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest

from stretch_bt.errors import SceneError
from stretch_bt.simulation.scene import load_scene, scene_names, scene_schema
from stretch_bt.simulation.world import World
from stretch_bt.source import load

GOOD = """\
format: stretch-scene/1
doc: A ball.
object:
  type: sphere
  diameter: 60 mm
  stiffness: 0.9 N/mm
  position: {x: 2 mm, y: -3 mm}
  base: 5 mm
camera: {noise: 0.2 mm, quantisation: 0.125 mm, dropout: 0.01}
robot: {repeatability: 0.05 mm, force_noise: 0.1 N}
force_sensor: {noise: 20 mN}
fidelity: hertz
seed: 3
"""

# (what is written, what instead of it, line, column, part of the message, part of the hint)
MISTAKES = [
    ("stretch-scene/1", "stretch-tree/1", 1, 9, "format", "stretch-scene/1"),
    ("object:", "objekt:", 3, 1, "unknown key 'objekt'", "object"),
    ("doc: A ball.", "doc: 3", 2, 6, "doc", ""),
    ("type: sphere", "type: spere", 4, 9, "no 'spere'", "sphere"),
    ("diameter: 60 mm", "diametre: 60 mm", 5, 3, "unknown key 'diametre'", "diameter"),
    ("diameter: 60 mm", "diameter: 60", 5, 13, "no unit", "60 mm"),
    ("diameter: 60 mm", "diameter: 60 N", 5, 13, "Force", "mm"),
    ("diameter: 60 mm", "diameter: 60 mn", 5, 13, "not a unit", ""),
    ("diameter: 60 mm", "diameter: 90 mm", 5, 13, "90 mm is out of bounds", "at most 80 mm"),
    ("diameter: 60 mm", "diameter: -60 mm", 5, 13, "out of bounds", "at least 5 mm"),
    ("diameter: 60 mm", "diameter: [60 mm]", 5, 13, "not a Length", "10 mm"),
    ("  diameter: 60 mm\n", "", 4, 3, "diameter is missing", "add 'diameter"),
    ("stiffness: 0.9 N/mm", "stiffness: 0.9 N", 6, 14, "not Stiffness", "N/mm"),
    ("stiffness: 0.9 N/mm", "stiffness: 0 N/mm", 6, 14, "out of bounds", "at least"),
    ("stiffness: 0.9 N/mm", "rigid: false", 4, 3, "either elastic or rigid", "rigid: true"),
    ("stiffness: 0.9 N/mm", "rigid: yes", 6, 10, "rigid", ""),
    ("x: 2 mm", "x: 2", 7, 17, "no unit", "2 mm"),
    ("y: -3 mm", "z: -3 mm", 7, 23, "unknown key 'z'", "x, y"),
    ("base: 5 mm", "base: -5 mm", 8, 9, "out of bounds", "at least 0 mm"),
    ("noise: 0.2 mm,", "noise: .inf,", 9, 17, "noise", ""),
    ("quantisation", "quantization", 9, 25, "unknown key", "quantisation"),
    ("dropout: 0.01", "dropout: 1.01", 9, 58, "out of bounds", "at most 1"),
    ("repeatability: 0.05 mm", "repeatability: 0.05 mm/s", 10, 24, "Speed", "mm"),
    ("noise: 20 mN", "noise: 20 mN, seed: 1", 11, 30, "unknown key 'seed'", "noise"),
    ("fidelity: hertz", "fidelity: herz", 12, 11, "fidelity", "hertz"),
    ("seed: 3", "seed: -3", 13, 7, "seed", ""),
    ("seed: 3", "seed: 3.5", 13, 7, "seed", ""),
    ("seed: 3", "seed: 3\nseed: 4", 14, 1, "twice", "keep one"),
]


@pytest.mark.parametrize(("right", "wrong", "line", "column", "said", "hint"), MISTAKES)
def test_each_mistake_is_found_at_its_place(tmp_path, right, wrong, line, column, said, hint):
    assert right in GOOD
    path = tmp_path / "scene.yaml"
    path.write_text(GOOD.replace(right, wrong, 1))
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    found = caught.value.diagnostics
    assert all(d.file == str(path) and d.severity == "error" for d in found)
    found = [
        d for d in found if d.code != "key-missing"
    ] or found  # a misspelt key is also missing under its right name
    assert [(d.line, d.column) for d in found] == [(line, column)], found
    assert said in found[0].message
    assert hint in found[0].hint
    assert found[0].hint


def test_every_mistake_is_reported_in_one_pass(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(GOOD.replace("60 mm", "60").replace("base", "bass").replace("seed: 3", "seed: x"))
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert sorted(d.line for d in caught.value.diagnostics) == [5, 8, 13]


def test_the_good_scene_is_read_in_si(tmp_path):
    path = tmp_path / "ball.yaml"
    path.write_text(GOOD)
    scene = load_scene(path)
    assert scene.name == "ball"
    assert (scene.object.diameter, scene.object.stiffness, scene.object.position.y) == pytest.approx(
        (0.06, 900, -0.003)
    )
    assert scene.force_sensor.noise == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("name", "said", "hint"), [("water_ballon", "no shipped scene", "water_balloon"), ("no.yaml", "no such file", "")]
)
def test_an_unknown_scene_is_refused(name, said, hint):
    with pytest.raises(SceneError) as caught:
        load_scene(name)
    assert said in caught.value.diagnostics[0].message
    assert hint in caught.value.diagnostics[0].hint


@pytest.mark.parametrize("name", scene_names())
def test_shipped_scenes_load_fit_the_schema_and_make_a_world(name):
    path = Path(str(files("stretch_bt"))) / "trees" / "scenes" / f"{name}.yaml"
    jsonschema.validate(load(path).plain(), scene_schema())
    scene = load_scene(name)
    assert scene.name == name
    assert scene.doc
    assert World(scene).object.top > 0
