"""The items of a sweep: which there are, and what their keys depend on."""

import os
import pickle
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest

from stretch_bt.errors import InvalidInput, SweepError
from stretch_bt.runtime.check import check
from stretch_bt.sweep import bundle, items

SCENE = "format: stretch-scene/1\nobject: {type: soft_sphere, diameter: 60 mm, stiffness: 1 N/mm}\n"
TREE = """\
format: stretch-tree/1
imports: {lib: ../lib/rest.yaml}
devices: {arm: Arm}
scene: own_scene.yaml
params: {height: {default: 20 mm}, table: {default: none, type: str}}
trees: {main: {sequence: [lib.rest, {retract: {clearance: $height}, log: $table}]}}
"""
REST = "format: stretch-tree/1\ntrees: {rest: {sequence: [{wait: {duration: 0.1 s}}]}}\n"
OF_MODULE = "format: stretch-tree/1\nimports: {own: %s}\ntrees: {main: {sequence: [{wait: {duration: 1 s}}]}}\n"
CELL = "format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated}, gripper: {type: Gripper, use: simulated}}\n"


@pytest.fixture
def whole(lab):
    """A sweep that names one of each kind of file."""
    lab.write("trees/own.yaml", TREE)
    lab.write("trees/own_scene.yaml", SCENE)
    lab.write("lib/rest.yaml", REST)
    lab.write("scenes/soft.yaml", SCENE)
    lab.write("cells/own.yaml", CELL)
    lab.write("table.csv", "1,2\n")
    lab.sweep(
        "tree: trees/own.yaml\nscene: scenes/soft.yaml\ncell: cells/own.yaml\n"
        "set: {height: 10 mm, table: table.csv}\ntolerance: {height: 1 mm}"
    )
    return lab


def key(lab):
    (spec,) = lab.specs()
    return spec.key


def test_items_are_the_product_of_all_lists_and_seeds_turn_fastest(lab):
    lab.sweep(
        "tree: [palpate_stiffness, palpate_active]\nscene: [water_balloon, air_balloon]\n"
        "seeds: {from: 3, count: 2}\nset: {touches: [3, 4], max_force: 5 N}"
    )
    found = [(s.tree, s.scene, s.params["touches"], s.seed) for s in lab.specs()]
    assert found == [
        (tree, scene, touches, seed)
        for tree in ("palpate_stiffness", "palpate_active")
        for scene in ("water_balloon", "air_balloon")
        for touches in ("3", "4")
        for seed in (3, 4)
    ]
    assert len({spec.key for spec in lab.specs()}) == 16


def test_without_a_scene_each_tree_has_its_own(lab):
    lab.sweep("tree: [palpate_stiffness, reconstruct]")
    assert [(s.scene, s.scene_name) for s in lab.specs()] == [("water_balloon",) * 2, ("wooden_cube",) * 2]


def test_a_spec_holds_texts_and_no_place_of_the_disk_but_its_origin(whole, tmp_path):
    (spec,) = whole.specs()
    assert str(tmp_path).encode() not in pickle.dumps(replace(spec, origin=""))
    assert spec.origin == str(whole.folder)
    assert (spec.tree, spec.scene, spec.cell, spec.home) == (
        "trees/own.yaml",
        "scenes/soft.yaml",
        "cells/own.yaml",
        ".",
    )
    assert spec.files.keys() == {
        "trees/own.yaml",
        "trees/own_scene.yaml",
        "lib/rest.yaml",
        "scenes/soft.yaml",
        "cells/own.yaml",
        "table.csv",
    }


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("trees/own.yaml", "0.1 s", "0.1 s"),
        ("lib/rest.yaml", "0.1 s", "0.2 s"),
        ("scenes/soft.yaml", "60 mm", "61 mm"),
        ("cells/own.yaml", "devices:", "doc: another\ndevices:"),
        ("table.csv", "1,2", "1,3"),
        ("sweep.yaml", "10 mm", "11 mm"),
        ("sweep.yaml", "tolerance: {height: 1 mm}", "tolerance: {height: 2 mm}"),
        ("sweep.yaml", "tolerance:", "seeds: {from: 1, count: 1}\ntolerance:"),
    ],
)
def test_the_key_is_another_where_anything_is_that_the_row_depends_on(whole, file, old, new):
    before = key(whole)
    path = whole.folder / file
    text = path.read_text()
    assert old in text or file == "trees/own.yaml"
    path.write_text(text.replace(old, new) if old != new else text + "# a comment\n")
    assert key(whole) != before


def test_the_key_is_another_with_another_package(whole, monkeypatch):
    before = key(whole)
    monkeypatch.setattr(items, "package_digest", lambda: "another")
    assert key(whole) != before


def test_the_key_is_another_with_another_text_of_a_module(lab, own_nodes, monkeypatch):
    """A module is imported once, so the second text stands in another folder under another name."""
    keys = []
    for number in (1, 2):
        lab.write(f"{number}/sweep_own_{number}.py", f"NUMBER = {number}\n")
        text = f"format: stretch-tree/1\nimports: {{own: sweep_own_{number}}}\ntrees: {{main: {{sequence: [{{wait: {{duration: 1 s}}}}]}}}}\n"
        lab.write(f"{number}/tree.yaml", text)
        lab.sweep(f"tree: {number}/tree.yaml")
        (spec,) = lab.specs()
        assert set(spec.files) == {f"{number}/tree.yaml", f"{number}/sweep_own_{number}.py"}
        keys.append(spec.key)
    assert keys[0] != keys[1]


def test_packages_beside_a_tree_go_along_and_count_whole(lab, own_nodes):
    """A package that a module imports was left at home, and rows stayed where it changed."""
    keys = []
    for number in (1, 2):
        names = f"beside_{number}", f"helpers_{number}"
        lab.write(f"{number}/{names[0]}.py", f"from {names[1]}.maths import f\n")
        lab.write(f"{number}/{names[1]}/__init__.py", "")
        lab.write(f"{number}/{names[1]}/maths.py", "def f(x):\n    return x\n")
        lab.write(f"{number}/{names[1]}/later.py", f"NUMBER = {number}\n")  # which nothing has imported yet
        text = f"format: stretch-tree/1\nimports: {{own: {names[0]}}}\ntrees: {{main: {{sequence: [{{wait: {{duration: 1 s}}}}]}}}}\n"
        lab.write(f"{number}/tree.yaml", text)
        lab.sweep(f"tree: {number}/tree.yaml")
        (spec,) = lab.specs()
        inner = {f"{number}/{names[1]}/{name}.py" for name in ("__init__", "maths", "later")}
        assert set(spec.files) == {f"{number}/tree.yaml", f"{number}/{names[0]}.py", *inner}
        keys.append(spec.key)
        lab.write(f"{number}/{names[1]}/later.py", "NUMBER = 9\n")
        keys.append(key(lab))
    assert len(set(keys)) == 4


def test_the_program_that_sweeps_is_no_module_of_the_tree_beside_it(lab, own_nodes, monkeypatch):
    """The command and a script had two keys, and each edit of the script made all keys new."""
    lab.write("sweep_of_program.py", "NUMBER = 1\n")
    lab.write("tree.yaml", OF_MODULE % "sweep_of_program")
    lab.sweep("tree: tree.yaml")
    before = key(lab)
    script = SimpleNamespace(__file__=str(lab.write("analysis.py", "NUMBER = 1\n")), __spec__=None)
    for name in ("__main__", "__mp_main__"):
        monkeypatch.setitem(sys.modules, name, script)
    assert key(lab) == before


@pytest.mark.parametrize("changed", ["sweep_edited.py", "sweep_edited_beside/maths.py"])
def test_a_module_that_was_changed_after_its_import_is_refused(lab, own_nodes, changed, monkeypatch):
    """Rows of the old code stood under the key of the new text."""
    for name in [name for name in sys.modules if name.startswith("sweep_edited")]:
        monkeypatch.delitem(sys.modules, name)
    lab.write("sweep_edited_beside/maths.py", "NUMBER = 1\n")
    lab.write("sweep_edited.py", "from sweep_edited_beside import maths\n")
    lab.write("tree.yaml", OF_MODULE % "sweep_edited")
    lab.sweep("tree: tree.yaml")
    check(lab.folder / "tree.yaml")  # imports it
    before, text = key(lab), (lab.folder / changed).read_text()
    (lab.folder / changed).write_text(text + "# changed\n")
    with pytest.raises(InvalidInput, match=rf"{changed} was changed after this process imported it; restart Python"):
        lab.specs()
    (lab.folder / changed).write_text(text)
    assert key(lab) == before


@pytest.mark.parametrize("more", ["limit: 1 min", "record: events", "doc: another"])
def test_what_the_row_does_not_depend_on_leaves_the_key(whole, more):
    before = key(whole)
    whole.file.write_text(f"{whole.file.read_text()}{more}\n")
    assert key(whole) == before


def test_the_key_does_not_depend_on_where_the_folder_is(whole, tmp_path, monkeypatch):
    before = key(whole)
    whole.folder.rename(tmp_path / "elsewhere")
    whole.folder = tmp_path / "elsewhere"
    assert key(whole) == before
    monkeypatch.chdir(tmp_path / "elsewhere")
    whole.folder = type(tmp_path)()
    assert key(whole) == before


def test_files_above_the_sweep_keep_their_places(lab):
    lab.write("trees/own.yaml", TREE)
    lab.write("trees/own_scene.yaml", SCENE)
    lab.write("lib/rest.yaml", REST)
    inner = lab.write("sweeps/deep/sweep.yaml", "format: stretch-sweep/1\ntree: ../../trees/own.yaml\n")
    lab.folder = inner.parent
    (spec,) = lab.specs()
    assert (spec.tree, spec.scene, spec.home) == ("../../trees/own.yaml", "../../trees/own_scene.yaml", "sweeps/deep")
    assert spec.scene_name == "own_scene.yaml"
    assert set(spec.files) == {"trees/own.yaml", "trees/own_scene.yaml", "lib/rest.yaml"}


def test_an_absolute_path_is_refused_at_its_place(lab, tmp_path):
    outside = tmp_path / "rest.yaml"
    outside.write_text(REST)
    lab.write("own.yaml", TREE.replace("../lib/rest.yaml", str(outside)).replace("own_scene.yaml", "water_balloon"))
    lab.sweep("tree: own.yaml")
    with pytest.raises(SweepError, match=r"own\.yaml:2:16 .*absolute path.*relative to this file"):
        lab.specs()


def test_files_too_large_to_be_handed_around_are_refused(whole, monkeypatch):
    monkeypatch.setattr(bundle, "MOST_BYTES", 100)
    with pytest.raises(InvalidInput, match="each item carries them"):
        whole.specs()


def test_a_text_that_is_no_name_is_no_file(lab):
    long = "x" * 300
    text = TREE.replace("../lib/rest.yaml", "rest.yaml").replace("own_scene.yaml", "water_balloon")
    lab.write("own.yaml", text.replace("default: none", f'default: "{long}"'))
    lab.write("rest.yaml", REST)
    os.mkfifo(lab.folder / "none")
    lab.sweep("tree: own.yaml\nset: {table: [none, lab, count.yaml]}")
    assert {name for spec in lab.specs() for name in spec.files} == {"own.yaml", "rest.yaml", "count.yaml"}
