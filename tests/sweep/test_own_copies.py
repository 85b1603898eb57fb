"""Modules of an item: its copies, wherever the originals are found, and a process that is as it was afterwards."""

import sys
from dataclasses import replace
from importlib.machinery import PathFinder
from types import ModuleType

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.sweep import run_item
from stretch_bt.sweep.own_copies import _Away, _kept, refuse_changed
from stretch_bt.tree import registry

NODE = '''\
import sys
from pathlib import Path
from stretch_bt import Behavior, Out, Status, node
from {name}_helper import NUMBER

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))


@node
class {title}(Behavior):
    """Give a number."""

    instant = True
    found: Out[int]

    def update(self):
        self.found = {found}
        return Status.SUCCESS
'''
TREE = """\
format: stretch-tree/1
imports: {own: %s}
trees: {main: {out: {found: int}, sequence: [{%s: {found: $found}}]}}
"""


def given(lab, name, found):
    """Return the item of a tree whose node gives `found`, as this machine has it and as a worker elsewhere lays it out."""
    lab.write(f"{name}.py", NODE.format(name=name, title=name.title().replace("_", ""), found=found))
    lab.write(f"{name}_helper.py", "NUMBER = 7\n")
    lab.write("own.yaml", TREE % (name, name))
    lab.sweep("tree: own.yaml\nseeds: 2")
    spec = lab.specs()[0]
    files = {f"{lab.folder.name}/{path}": content for path, content in spec.files.items()}
    return spec, replace(spec, files=files, home=lab.folder.name, origin=str(lab.folder.parent))


def row(spec):
    return {name: value for name, value in run_item(spec).row.items() if not name.endswith("_seconds")}


class Editable:
    """Finds a module in a folder, as the finder of an editable install does."""

    def __init__(self, folder):
        self.folder = folder

    def find_spec(self, name, path=None, target=None):
        return PathFinder.find_spec(name, [str(self.folder)]) if path is None else None


@pytest.mark.parametrize("leads", ["path", "finder", "nothing"])
def test_rows_are_the_same_where_the_folder_of_the_tree_is_on_the_path(lab, own_nodes, monkeypatch, leads):
    """A script beside the tree: each item of a worker was an ERROR, for another module had the name of the copy."""
    monkeypatch.setattr(sys, "path", [*([str(lab.folder)] if leads == "path" else []), *sys.path])
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, *([Editable(lab.folder)] if leads == "finder" else [])])
    name = f"sweep_copied_{leads}"
    here, elsewhere = given(lab, name, "NUMBER")
    before = sys.modules[name], sys.modules[f"{name}_helper"], registry.known(), list(sys.path)
    rows = [row(spec) for spec in (here, elsewhere, here)]
    assert rows[0]["status"] == "SUCCESS"
    assert rows[0]["outputs"]["found"]["value"] == 7
    assert rows[0] == rows[1] == rows[2]
    assert (sys.modules[name], sys.modules[f"{name}_helper"], registry.known(), list(sys.path)) == before


def test_a_file_that_nothing_names_is_beside_no_copy(lab, own_nodes):
    """This process alone had it, under a key that did not depend on it."""
    lab.write("table.csv", "7\n")
    rows = [row(spec) for spec in given(lab, "sweep_unnamed", "int((HERE / 'table.csv').read_text())")]
    assert rows[0] == rows[1]
    assert rows[0]["status"] != "SUCCESS"
    assert "No such file or directory: 'table.csv'" in rows[0]["reason"]


def test_a_module_is_executed_once_for_all_items_of_a_sweep(lab, own_nodes):
    spec, _ = given(lab, "sweep_once", "globals().setdefault('ran', []).append(0) or len(ran)")
    assert [row(spec)["outputs"]["found"]["value"] for _ in range(3)] == [1, 2, 3]


def test_a_module_of_the_same_last_name_in_a_package_is_another_one(tmp_path):
    _kept[tmp_path] = _Away({"motions": ModuleType("motions")})
    _kept[tmp_path].modules["motions"].__file__ = str(tmp_path / "motions.py")
    (tmp_path / "motions.py").write_text("A = 1\n")
    try:
        refuse_changed({"lab/own/motions.py": b"A = 2\n", "lab/tree.yaml": b""})
        with pytest.raises(InvalidInput, match="another 'motions'"):
            refuse_changed({"lab/motions.py": b"A = 2\n", "lab/tree.yaml": b""})
    finally:
        del _kept[tmp_path]
