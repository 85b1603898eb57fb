"""Params that a scene asks for."""

import re
from pathlib import Path

import pytest

from stretch_bt import run
from stretch_bt.errors import FileError

TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
scene: scene.yaml
params: {max_force: {type: Force, default: 5 N}, number: {type: int, default: 3}}
trees:
  main:
    out: {force: Force, frames: int}
    sequence:
      - check: arm.force < 1 N
      - set: {force: max_force, frames: number}
"""
SCENE = "format: stretch-scene/1\nobject: {type: box, length: 40 mm, width: 40 mm, height: 40 mm, rigid: true}\n"


@pytest.fixture
def outputs(tmp_path):
    def made(asked="", **options):
        (tmp_path / "tree.yaml").write_text(TREE)
        (tmp_path / "scene.yaml").write_text(SCENE + asked)
        result = run(tmp_path / "tree.yaml", out=tmp_path / "record", **options)
        return result.outputs["force"]["value"], result.outputs["frames"]["value"]

    return made


def test_a_run_begins_with_the_params_of_its_scene(outputs):
    assert outputs("params: {max_force: 0.8 N, number: 7}\n") == (0.8, 7)


def test_what_the_run_sets_comes_first(outputs):
    assert outputs("params: {max_force: 0.8 N, number: 7}\n", params={"max_force": "2 N"}) == (2.0, 7)


MOCKS = """\
format: stretch-mocks/1
tree: tree.yaml
mocks: []
readings: {arm.force: 0 N}
"""


@pytest.mark.parametrize("named", [False, True])
def test_a_run_that_opens_no_device_begins_with_the_params_of_its_scene(outputs, tmp_path, named):
    (tmp_path / "mocks.yaml").write_text(MOCKS)
    options = {"scene": tmp_path / "scene.yaml"} if named else {}
    assert outputs("params: {max_force: 0.8 N}\n", mocks=tmp_path / "mocks.yaml", **options) == (0.8, 3)


def test_a_tree_without_devices_begins_with_the_params_of_its_scene(tmp_path):
    (tmp_path / "tree.yaml").write_text(
        TREE.replace("devices: {arm: Arm}\n", "").replace("      - check: arm.force < 1 N\n", "")
    )
    (tmp_path / "scene.yaml").write_text(f"{SCENE}params: {{max_force: 0.8 N, warmth: 3}}\n")
    result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
    assert result.outputs["force"]["value"] == 0.8
    assert "no param 'warmth'" in result.notes[0]


def test_a_run_on_mocks_of_a_real_cell_leaves_the_scene_alone(outputs, tmp_path):
    (tmp_path / "mocks.yaml").write_text(MOCKS)
    given = {"mocks": tmp_path / "mocks.yaml", "cell": "lab_ur5e", "scene": tmp_path / "scene.yaml"}
    assert outputs("params: {max_force: 0.8 N}\n", **given) == (5.0, 3)


def test_devices_that_are_no_twin_leave_the_scene_alone(outputs):
    from stretch_bt.clock import VirtualClock
    from stretch_bt.hardware.cell import open_cell
    from stretch_bt.hardware.cell_file import load_cell
    from stretch_bt.simulation.scene import load_scene

    cell = open_cell(load_cell("simulated"), clock=VirtualClock(), seed=0, scene=load_scene("wooden_cube"))
    assert outputs("params: {max_force: 0.8 N}\n", devices={"arm": cell.devices["arm"]})[0] == 5.0


def test_devices_of_a_twin_bring_the_params_of_its_scene(outputs, cell, tmp_path):
    (tmp_path / "other.yaml").write_text(SCENE + "params: {max_force: 0.8 N}\n")
    devices = cell(tmp_path / "other.yaml").devices
    assert outputs("params: {max_force: 0.7 N}\n", devices={"arm": devices["arm"]})[0] == 0.8


def test_a_scene_without_params_changes_none(outputs):
    assert outputs() == (5.0, 3)


@pytest.mark.parametrize(
    ("asked", "column", "message"),
    [
        ("params: {max_force: 3 mm}\n", 21, "max_force"),
        ("params: {max_force: much}\n", 21, "max_force"),
        ("params: {frames: 3, max_froce: 3 N}\n", 21, "no param 'max_froce'; did you mean 'max_force'?"),
    ],
)
def test_a_mistake_is_told_at_its_place_in_the_scene_before_anything_moves(outputs, asked, column, message):
    with pytest.raises(FileError, match=re.escape(message)) as caught:
        outputs(asked)
    (found,) = caught.value.diagnostics
    assert (Path(found.file).name, found.line, found.column) == ("scene.yaml", 3, column)


@pytest.mark.parametrize("name", ["warmth", "max_frames"])
def test_a_name_that_the_tree_does_not_have_is_told(tmp_path, name):
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "scene.yaml").write_text(f"{SCENE}params: {{max_force: 0.8 N, {name}: 3}}\n")
    (note,) = run(tmp_path / "tree.yaml", out=tmp_path / "record").notes
    assert "scene.yaml:3:28 warning[param-unknown]" in note


@pytest.mark.parametrize("kind", ["cube", "half_cylinder", "pyramid"])
def test_paper_is_pressed_below_what_its_walls_bear(kind):
    from stretch_bt.simulation.scene import load_scene
    from stretch_bt.source.scene_params import scene_params
    from stretch_bt.units import parse_quantity

    scene = f"paper_{kind}"
    (asked,) = [parse_quantity(v.text)[0] for k, v in scene_params(scene).items() if k.text == "max_force"]
    assert asked < 0.8 * load_scene(scene).object.compliance().critical
