"""Each file of one `check` is judged by what it names itself."""

import sys

import pytest

from stretch_bt import check, run
from stretch_bt.runtime.fix import fix_files
from stretch_bt.tree import registry

NODE = '''
from stretch_bt import Behavior, Status, node

@node
class Nods(Behavior):
    """Nods."""
    instant = True

    def update(self) -> Status:
        return Status.SUCCESS
'''
TREE = "format: stretch-tree/1\n{}trees: {{main: {{sequence: [nods]}}}}\n"


@pytest.fixture
def folder(tmp_path):
    """Trees with a node of the same name from two modules, from one of these through a third, and from nowhere."""
    for module in ("apart_one", "apart_two"):
        (tmp_path / f"{module}.py").write_text(NODE)
    (tmp_path / "apart_all.py").write_text("import apart_one\n")
    for name in ("one", "two", "all"):
        (tmp_path / f"{name}.yaml").write_text(TREE.format(f"imports: {{own: apart_{name}}}\n"))
    (tmp_path / "none.yaml").write_text(TREE.format(""))
    return tmp_path


@pytest.mark.parametrize("order", ["one none", "one two one", "one all none", "all one", "two none all"])
@pytest.mark.parametrize("cell", [None, "simulated"])
def test_a_file_is_judged_as_it_is_alone(folder, order, cell):
    files = [folder / f"{name}.yaml" for name in order.split()]
    found = check(files, cell=cell)
    assert [d.code for d in found] == ["node-unknown"] * order.count("none")
    assert found == [finding for file in files for finding in check(file, cell=cell)]
    assert not [name for name in sys.modules if name.startswith("apart_")]


@pytest.mark.parametrize("ran", ["one", "all"])
def test_a_file_is_judged_alone_after_a_run(folder, ran):
    """What a run brought stays as it was, no other file may rest on it, and a check sees what is written now."""
    run(folder / f"{ran}.yaml", record="none")
    brought = sys.modules["apart_one"]
    try:
        files = [folder / f"{name}.yaml" for name in ("none", "one", "all")]
        assert [d.code for d in check(files)] == ["node-unknown"]
        assert sys.modules["apart_one"] is brought
        (folder / "apart_one.py").write_text(NODE.replace("Nods", "Winks"))
        assert [d.code for d in check(files)] == ["node-unknown"] * 3
        assert run(folder / f"{ran}.yaml", record="none").status == "SUCCESS"
    finally:
        forgotten = [name for name in sys.modules if name.startswith("apart_")]
        registry.forget(info.name for info in registry.known().values() if info.cls.__module__ in forgotten)
        for name in forgotten:
            del sys.modules[name]


def test_files_that_are_fixed_are_judged_alone(folder):
    """The module of the first file made the second one right, which so was rewritten by what it does not name."""
    older = (
        "format: stretch-tree/1\n{}keys: {{n: {{type: int}}}}\ntrees: {{main: {{sequence: [nods, set: {{n: 1}}]}}}}\n"
    )
    one, none = folder / "older.yaml", folder / "older_none.yaml"
    one.write_text(older.format("imports: {own: apart_one}\n"))
    none.write_text(older.format(""))
    fix_files([str(one), str(none)])
    assert "keys" not in one.read_text()
    assert none.read_text() == older.format("")
