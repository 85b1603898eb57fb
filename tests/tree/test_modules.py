"""A tree executes no Python module but those that are installed or stand beside the tree that the user named."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt.hardware.own_modules import ModuleRefused, Modules
from stretch_bt.runtime.record import RunRecord

COMMAND = str(Path(sys.executable).with_name("stretch-bt"))
LEAVE = "open(__file__ + '.ran', 'w').close()\n"
NODE = """
from stretch_bt import Behavior, Status, node

@node
class OwnNode(Behavior):
    'Does nothing.'

    def update(self) -> Status:
        return Status.SUCCESS
"""
TREE = "format: stretch-tree/1\nimports:\n  own: %s\ntrees: {main: {sequence: [wait: {duration: 1 ms}%s]}}\n"


@pytest.fixture
def folders(tmp_path):
    """Return the folder of a tree and another one, where the command is run."""
    for name in ("trees", "elsewhere"):
        (tmp_path / name).mkdir()
    return tmp_path / "trees", tmp_path / "elsewhere"


def put(folder, name, text=LEAVE):
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text)
    return folder / name


def command(cwd, *args, python=(COMMAND,), **env):
    done = subprocess.run(
        [*python, *args], cwd=cwd, capture_output=True, text=True, timeout=120, check=False, env={**os.environ, **env}
    )
    assert "Traceback" not in done.stderr
    return done


def executed(folder):
    return sorted(path.name for path in folder.rglob("*.ran"))


PYTHON = (sys.executable, "-m", "stretch_bt")


@pytest.mark.parametrize(
    ("python", "verb"),
    [
        ((COMMAND,), "check"),
        (PYTHON, "run"),
        *(pytest.param((COMMAND,), verb, marks=pytest.mark.slow) for verb in ("run", "show")),
        *(pytest.param(PYTHON, verb, marks=pytest.mark.slow) for verb in ("check", "show")),
    ],
)
def test_a_module_of_the_current_folder_is_not_executed(folders, python, verb):
    trees, elsewhere = folders
    put(elsewhere, "their_nodes.py")
    put(trees, "tree.yaml", TREE % ("their_nodes", ""))
    done = command(elsewhere, verb, str(trees / "tree.yaml"), python=python, PYTHONPATH=os.pathsep + ".")
    assert executed(elsewhere) == []
    assert done.returncode == 2
    said = done.stdout + done.stderr
    assert "tree.yaml:3:8" in said
    assert "no Python module 'their_nodes' is installed, and none is beside the tree" in said
    assert "put the module beside the tree" in said


def test_a_module_beside_the_tree_is_found_from_any_folder(folders):
    trees, elsewhere = folders
    put(trees, "own_nodes.py", LEAVE + NODE)
    put(elsewhere, "own_nodes.py", "1 / 0")
    put(trees, "tree.yaml", TREE % ("own_nodes", ", own_node: {}"))
    assert command(elsewhere, "check", str(trees / "tree.yaml")).returncode == 0
    assert executed(trees) == ["own_nodes.py.ran"]


def test_a_library_below_the_tree_brings_modules_and_one_elsewhere_does_not(folders):
    trees, elsewhere = folders
    library = (
        "format: stretch-tree/1\nimports: {own: %s}\ntrees: {pause: {in: {n: {type: int, default: 1}}, check: n > 0}}\n"
    )
    for folder, name in ((trees / "lib", "near_nodes"), (elsewhere, "far_nodes")):
        put(folder, f"{name}.py")
        put(folder, "lib.yaml", library % name)
    put(trees, "near.yaml", TREE % ("lib/lib.yaml", ", own.pause: {}"))
    put(trees, "far.yaml", TREE % ("../elsewhere/lib.yaml", ", own.pause: {}"))
    done = command(elsewhere, "check", str(trees / "near.yaml"), str(trees / "far.yaml"), "--json")
    [found] = json.loads(done.stdout)
    assert (found["code"], found["line"]) == ("import", 2)
    assert "far_nodes" in found["message"]
    assert executed(trees) == ["near_nodes.py.ran"]
    assert executed(elsewhere) == []


def found_in_each(cwd, paths):
    """Return the one finding in each of some trees."""
    found = json.loads(command(cwd, "check", *map(str, paths), "--json").stdout)
    assert [finding["file"] for finding in found] == [str(path) for path in paths]
    return found


def test_a_module_beside_the_tree_takes_no_installed_name(folders):
    trees, elsewhere = folders
    names = ["json", "numpy", "colorsys", "stretch_bt"]
    for name in names:
        put(trees / name, f"{name}.py")
    for found in found_in_each(elsewhere, [put(trees / name, "tree.yaml", TREE % (name, "")) for name in names]):
        assert found["code"] == "import"
        assert "has the name of another one" in found["message"]
        assert found["hint"] == "rename the module beside the tree"
    assert executed(trees) == []


def test_what_a_module_imports_is_not_taken_from_its_folder_before_the_installed(folders):
    trees, elsewhere = folders
    put(trees, "own_nodes.py", "import colorsys\ncolorsys.rgb_to_hsv\nimport own_help\n")
    put(trees, "own_help.py")
    put(trees, "colorsys.py")
    put(trees, "tree.yaml", TREE % ("own_nodes", ""))
    assert command(elsewhere, "check", str(trees / "tree.yaml")).returncode == 0
    assert executed(trees) == ["own_help.py.ran"]


def test_two_trees_with_modules_of_one_name_are_not_mixed_up(folders):
    for folder in folders:
        put(folder, "own_nodes.py")
        put(folder, "tree.yaml", TREE % ("own_nodes", ""))
    done = command(folders[0], "check", *(str(folder / "tree.yaml") for folder in folders), "--json")
    assert json.loads(done.stdout) == []
    assert [executed(folder) for folder in folders] == [["own_nodes.py.ran"]] * 2


def test_a_package_on_pythonpath_counts_as_installed(folders):
    trees, elsewhere = folders
    put(elsewhere, "own_nodes.py")
    put(trees, "tree.yaml", TREE % ("own_nodes", ""))
    assert command(trees, "check", "tree.yaml", PYTHONPATH=str(elsewhere)).returncode == 0
    assert executed(elsewhere) == ["own_nodes.py.ran"]


def test_mocks_bring_the_modules_of_a_tree_beside_them_only(folders):
    trees, elsewhere = folders
    for folder, name, way in ((trees, "near", ""), (elsewhere, "far", "../trees/")):
        put(trees, f"{name}_nodes.py")
        put(trees, f"{name}.yaml", TREE % (f"{name}_nodes", ""))
        mocks = f"format: stretch-mocks/1\ntree: {way}{name}.yaml\nmocks: [{{match: '**/wait'}}]\n"
        put(folder, "mocks.yaml", mocks)
    done = command(elsewhere, "check", *(str(folder / "mocks.yaml") for folder in folders), "--json")
    [found] = json.loads(done.stdout)
    assert (found["file"], found["code"]) == (str(elsewhere / "mocks.yaml"), "tree-wrong")
    assert executed(trees) == ["near_nodes.py.ran"]


def test_what_is_no_name_of_a_module_is_said(folders):
    trees, elsewhere = folders
    names = ["..own", ".own", "a-b", "own.py/x", "own nodes", "/own", "typer.__main__"]
    paths = [put(trees, f"tree{k}.yaml", TREE % (f"'{name}'", "")) for k, name in enumerate(names)]
    for found in found_in_each(elsewhere, paths):
        assert found["code"] == "import"
        assert "not the name of a Python module" in found["message"], found


def test_a_record_executes_no_module_unless_it_is_trusted(folders):
    """And a replay knows the modules that its nodes import from beside the tree, and says when they are others."""
    trees, elsewhere = folders
    for name in ("init", "commit"):
        options = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
        git = ["git", *options, name, "-q", *(["--allow-empty", "-m", "one"] if name == "commit" else [])]
        subprocess.run(git, cwd=trees, check=True, timeout=60)
    module = put(trees, "own_nodes.py", "import own_helper\n" + LEAVE + NODE)
    put(trees, "own_helper.py", LEAVE)
    put(trees, "tree.yaml", TREE % ("own_nodes", ", own_node: {}"))
    assert command(elsewhere, "run", str(trees / "tree.yaml"), "--out", "record", "-q").returncode == 0
    modules = json.loads((elsewhere / "record" / "run.json").read_text())["modules"]
    assert "own_helper" in modules
    assert modules["own_nodes"]["sha256"] == hashlib.sha256(module.read_bytes()).hexdigest()
    assert len(modules["own_nodes"]["commit"]) == 40
    for left in executed(trees):
        (trees / left).unlink()
    refused = command(elsewhere, "replay", "record", "--json")
    assert refused.returncode == 2
    assert "--trust" in refused.stderr
    assert executed(trees) == []
    trusted = command(elsewhere, "replay", "record", "--trust", "--json")
    assert json.loads(trusted.stdout)["identical"]
    assert json.loads(trusted.stdout)["others"] == []
    assert "another module" not in trusted.stderr
    assert executed(trees) == ["own_helper.py.ran", "own_nodes.py.ran"]
    said = [line for line in trusted.stderr.splitlines() if line.startswith("executing")]
    assert said == [f"executing {trees.resolve() / name}.py" for name in ("own_nodes", "own_helper")]
    module.write_text(module.read_text() + "# changed\n")
    changed = command(elsewhere, "replay", "record", "--trust", "--json")
    [other] = json.loads(changed.stdout)["others"]
    assert str(module.resolve()) in other
    assert other in changed.stderr


@pytest.mark.parametrize(
    "carried",
    [
        "own_nodes.py",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("../own_nodes.py", "own_nodes/__init__.py", "a/b/own_nodes.py")
        ),
    ],
)
def test_a_record_that_carries_a_module_executes_none(folders, carried):
    """Written as by an attacker, with digests that hold: the module as if it were a tree that the tree imports."""
    trees, elsewhere = folders
    tree = put(trees, "tree.yaml", TREE % ("own_nodes", ", own_node: {}"))
    record = RunRecord(elsewhere / "record")
    sources = {
        "tree.yaml": tree.read_text(),
        carried: LEAVE.replace("__file__", repr(str(trees / "own_nodes.py"))) + NODE,
    }
    record.start({}, {"tree": str(elsewhere / "tree.yaml"), "sources": sources, "mocks": None})
    record.close({})
    for flags in ((), ("--trust",)):
        done = command(elsewhere, "replay", "record", "--json", *flags)
        assert done.returncode == 2
        assert "no Python module 'own_nodes' is installed" in done.stderr
        assert executed(trees) == executed(elsewhere) == []


def test_reading_a_tree_leaves_the_path_as_it_was(folders):
    trees, _ = folders
    put(trees, "path_nodes.py", "import sys\nsys.path.append('left behind')\n")
    before = list(sys.path)
    try:
        Modules.beside(trees / "tree.yaml").bring("path_nodes", trees / "tree.yaml")
        assert sys.path == before
    finally:
        sys.modules.pop("path_nodes", None)


def test_a_module_that_python_cannot_compile_is_told_with_its_file(tmp_path: Path) -> None:
    put(tmp_path, "too_deep.py", "x = " + "(" * 150 + "1" + "+1)" * 150 + "\ny = " + "-" * 100_000 + "1\n")
    with pytest.raises(
        ModuleRefused, match=r"'too_deep' cannot be imported: \w+Error[^;]* \(.*too_deep\.py"
    ) as refused:
        Modules.beside(tmp_path / "tree.yaml").bring("too_deep", tmp_path / "tree.yaml")
    assert ": (" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "home"), [("Length", "units"), ("NoAnswer", "errors"), ("Arm", "hardware.interfaces")]
)
def test_a_name_that_is_sought_in_the_wrong_place_is_told_with_its_own(tmp_path: Path, name: str, home: str) -> None:
    put(tmp_path, "astray.py", f"from stretch_bt import {name}\n")
    with pytest.raises(ModuleRefused) as refused:
        Modules.beside(tmp_path / "tree.yaml").bring("astray", tmp_path / "tree.yaml")
    assert refused.value.hint == f"write 'from stretch_bt.{home} import {name}'"


def test_a_current_folder_that_is_gone_keeps_no_tree_from_its_check(folders):
    trees, elsewhere = folders
    tree = put(trees, "tree.yaml", TREE % ("own_gone", ", own_node"))
    put(trees, "own_gone.py", NODE)
    shell = 'rmdir "$PWD"; exec "$@"'
    here = ("/bin/sh", "-c", shell, "sh", *PYTHON)
    done = command(elsewhere, "check", str(tree), python=here)
    assert (done.returncode, done.stderr) == (0, "")
    elsewhere.mkdir()
    done = command(elsewhere, "run", str(tree), "-q", python=here)
    assert done.returncode == 2
    assert "the current folder is gone" in done.stderr
    assert "--out" in done.stderr


BEHAVIOUR = """
import py_trees

class Own(py_trees.behaviour.Behaviour):
    def __init__(self, name: str):
        super().__init__(name)

    def update(self):
        return py_trees.common.Status.SUCCESS

Own.Inner = Own
"""
#: what is imported of a package beside the tree, and which of its files that executes
CLASSES = {
    "pkg.near.Own": ["__init__.py.ran", "near.py.ran"],
    "pkg.Own": ["__init__.py.ran"],
    "pkg.near.Own.Inner": ["__init__.py.ran", "near.py.ran"],
    "pkg.near": ["__init__.py.ran", "near.py.ran"],
    "space.inner.near.Own": ["near.py.ran"],
}


def test_of_the_name_of_a_class_only_its_modules_are_executed(folders):
    """And one of a module that is not beside the tree is not looked for."""
    trees, elsewhere = folders
    put(elsewhere, "their_nodes.py", LEAVE + BEHAVIOUR)
    paths = [put(trees, "tree.yaml", TREE % ("their_nodes.Own", ", own: {}"))]
    for k, name in enumerate(CLASSES):
        package, *rest = name.split(".")
        beside = trees / str(k)
        for file in ("__init__", "near", "far"):
            put(beside / f"pkg{k}", f"{file}.py", LEAVE + BEHAVIOUR)
        put(beside / f"space{k}" / "inner", "near.py", LEAVE + BEHAVIOUR)  # folders without __init__.py
        node = ", own.Own: {}" if name == "pkg.near" else ", own: {}"
        paths.append(put(beside, "tree.yaml", TREE % (".".join([f"{package}{k}", *rest]), node)))
    done = command(elsewhere, "check", *map(str, paths), "--json")
    [found] = json.loads(done.stdout)
    assert (done.returncode, found["file"], executed(elsewhere)) == (2, str(paths[0]), [])
    assert "no Python module 'their_nodes' is installed, and none is beside the tree" in found["message"]
    assert {name: executed(trees / str(k)) for k, name in enumerate(CLASSES)} == CLASSES
