"""A sweep file held against its trees, their params, its scenes and its cell."""

from pathlib import Path

import pytest

from stretch_bt.runtime import sweep_check
from stretch_bt.runtime.apart import apart
from stretch_bt.runtime.check import check
from stretch_bt.runtime.sweep_check import check_sweep
from stretch_bt.tree.program import load_program

TREE = """\
format: stretch-tree/1
imports: {lib: lib.yaml}
params:
  {height: {default: 20 mm, min: 1 mm, max: 50 mm}, times: {default: 1}, word: {default: one, type: str}, part: {default: 0.5}, all: {default: true}}
trees: {main: {sequence: [{lib.rest: {}, log: "$height $times $word $part $all"}]}}
"""
LIBRARY = """\
format: stretch-tree/1
params: {rest: {default: 1 s}}
trees: {rest: {sequence: [{wait: {duration: $rest}}]}}
"""
WRONG = {
    "tree: nothing": ("file-missing", "2:7"),
    "tree: lib.yaml": ("main-missing", "2:7"),
    "tree: broken.yaml": ("tree-wrong", "2:7"),
    "scene: no_balloon": ("scene-unknown", "3:8"),
    "scene: no.yaml": ("file-missing", "3:8"),
    "cell: no_cell": ("cell-unknown", "4:7"),
    "cell: lab_ur5": ("value", "4:7"),
    "set: {heigth: 3 mm}": ("param-unknown", "5:7"),
    "set: {height: [3 mm, 3]}": ("unit-missing", "5:22"),
    "set: {height: [3 mm, 60 mm]}": ("out-of-bounds", "5:22"),
    "set: {height: [[1 mm, 2 mm]]}": ("type-mismatch", "5:16"),
    "set: {height: {a: 1}}": ("type-mismatch", "5:15"),
    "set: {part: [3, 3.0]}": ("value", "5:17"),
    "set: {part: [5 %, 0.05]}": ("value", "5:19"),
    "set: {all: [true, True]}": ("value", "5:19"),
    "set: {times: 1.5}": ("type-mismatch", "5:14"),
    "set: {lib.rest: 1 mm}": ("unit-mismatch", "5:17"),
    "set: {lib.res: 1 s}": ("param-unknown", "5:7"),
}


@pytest.fixture
def sweep(tmp_path):
    """Write a sweep of an own tree with one line in place of the line with the same key."""
    for name, text in {"own.yaml": TREE, "lib.yaml": LIBRARY, "broken.yaml": TREE + "x: 1\n"}.items():
        (tmp_path / name).write_text(text)

    def write(line=""):
        lines = [
            "format: stretch-sweep/1",
            "tree: own.yaml",
            "scene: water_balloon",
            "cell: simulated",
            "set: {times: 2}",
        ]
        lines = [line if line and old.startswith(f"{line.partition(':')[0]}:") else old for old in lines]
        (tmp_path / "sweep.yaml").write_text("\n".join(lines) + "\n")
        return tmp_path / "sweep.yaml"

    return write


@pytest.mark.parametrize(
    "line", ["", "set: {height: [1 mm, 2cm], word: [two, '3'], lib.rest: 2 s}", "tree: [own.yaml]"]
)
def test_what_is_right_is_not_complained_about(sweep, line):
    assert check(sweep(line)) == []


@pytest.mark.parametrize("line", WRONG)
def test_what_it_names_is_held_against_it(sweep, line):
    found = [(d.code, f"{d.line}:{d.column}") for d in check(sweep(line))]
    assert found == [WRONG[line]]


def test_mistakes_in_a_scene_are_told_at_their_own_places(sweep, tmp_path):
    (tmp_path / "wrong.yaml").write_text("format: stretch-scene/1\nobject: {type: balloon, diameter: 3}\n")
    found = check(sweep("scene: wrong.yaml"))
    assert {d.file for d in found} == {str(tmp_path / "wrong.yaml")}


def test_a_tree_with_devices_needs_a_scene(tmp_path):
    (tmp_path / "up.yaml").write_text(
        "format: stretch-tree/1\ndevices: {arm: Arm}\ntrees: {main: {sequence: [{retract: {clearance: 1 mm}}]}}\n"
    )
    path = tmp_path / "sweep.yaml"
    path.write_text("format: stretch-sweep/1\ntree: up.yaml\n")
    assert [(d.code, d.hint) for d in check(path)] == [("key-missing", "add 'scene: water_balloon'")]


def test_a_cell_without_the_devices_of_a_tree_is_refused(tmp_path):
    (tmp_path / "up.yaml").write_text(
        "format: stretch-tree/1\ndevices: {sensor: ForceSensor}\nscene: water_balloon\n"
        "trees: {main: {sequence: [zero_force]}}\n"
    )
    (tmp_path / "arm.yaml").write_text("format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated}}\n")
    path = tmp_path / "sweep.yaml"
    path.write_text("format: stretch-sweep/1\ntree: up.yaml\nscene: water_balloon\ncell: arm.yaml\n")
    assert [(d.code, f"{d.line}:{d.column}") for d in check(path)] == [("device-missing", "4:7")]


def test_modules_beside_a_tree_elsewhere_are_not_imported(tmp_path):
    """Whoever names a sweep file chose its folder, and not the folder of any tree which it names."""
    for name in ("sweeps", "trees"):
        (tmp_path / name).mkdir()
    (tmp_path / "trees" / "own_elsewhere.py").write_text("raise SystemExit('executed')\n")
    (tmp_path / "trees" / "own.yaml").write_text(
        "format: stretch-tree/1\nimports: {own: own_elsewhere}\ntrees: {main: {sequence: [{wait: {duration: 1 s}}]}}\n"
    )
    path = tmp_path / "sweeps" / "sweep.yaml"
    path.write_text("format: stretch-sweep/1\ntree: ../trees/own.yaml\n")
    found = check_sweep(path)
    assert [d.code for d in found.diagnostics] == ["tree-wrong"]
    assert "put the sweep file beside the tree" in found.diagnostics[0].hint


@pytest.mark.parametrize(("at", "right"), [("trees", True), ("", False), ("lib", False)])
@pytest.mark.parametrize("kind", ["sweep", "mocks"])
def test_modules_stand_where_a_run_looks_for_them(tmp_path, own_nodes, kind, at, right):
    """Beside a tree in a folder below; one beside the sweep file alone was right here, and no worker had it."""
    name = f"own_{kind}_{at}"
    for folder in ("trees", "lib"):
        (tmp_path / folder).mkdir()
    (tmp_path / at / f"{name}.py").write_text("NUMBER = 1\n")
    (tmp_path / "lib" / "lib.yaml").write_text(LIBRARY + f"imports: {{own: {name}}}\n" * (at == "lib"))
    imports = "lib: ../lib/lib.yaml" + f", own: {name}" * (at != "lib")
    (tmp_path / "trees" / "own.yaml").write_text(
        f"format: stretch-tree/1\nimports: {{{imports}}}\ntrees: {{main: {{sequence: [lib.rest]}}}}\n"
    )
    path = tmp_path / "given.yaml"
    path.write_text(f"format: stretch-{kind}/1\ntree: trees/own.yaml\n" + "mocks: []\n" * (kind == "mocks"))
    assert [d.code for d in check(path)] == ([] if right else ["tree-wrong"])
    assert any(d.severity == "error" for d in check(tmp_path / "trees" / "own.yaml")) is not right


def test_every_mistake_is_told_at_once(tmp_path, sweep):
    path = sweep("set: {heigth: 3 mm, times: 1.5}")
    path.write_text(path.read_text().replace("water_balloon", "no_balloon") + "limit: 3\nseeds: {count: 0}\n")
    found = sorted((d.line, d.column, d.code) for d in check_sweep(path).diagnostics)
    assert found == [
        (3, 8, "scene-unknown"),
        (5, 7, "param-unknown"),
        (5, 28, "type-mismatch"),
        (6, 8, "value"),
        (7, 16, "value"),
    ]


def test_trees_without_own_nodes_are_read_once(tmp_path, monkeypatch):
    """Nothing of one can make another right."""
    read = []

    def load(tree, *rest):
        read.append(Path(tree).name)
        return load_program(tree, *rest)

    monkeypatch.setattr(sweep_check, "load_program", load)
    names = [f"{i}.yaml" for i in range(3)]
    for name in names:
        (tmp_path / name).write_text("format: stretch-tree/1\ntrees: {main: {sequence: [wait: {duration: 1 s}]}}\n")
    (tmp_path / "sweep.yaml").write_text(f"format: stretch-sweep/1\ntree: [{', '.join(names)}]\n")
    with apart():  # from what other tests brought
        assert not check_sweep(tmp_path / "sweep.yaml").diagnostics
    assert read == names


def test_a_tree_of_a_sweep_has_no_nodes_that_another_one_imports(tmp_path):
    """It ran with them, though not by itself."""
    body = "trees: {main: {sequence: [borrowed_for_test]}}"
    (tmp_path / "own_of_one.py").write_text(
        "from stretch_bt import Behavior, Status, node\n\n\n@node\nclass BorrowedForTest(Behavior):\n"
        '    """Do nothing."""\n\n    def update(self):\n        return Status.SUCCESS\n'
    )
    (tmp_path / "one.yaml").write_text(f"format: stretch-tree/1\nimports: {{own: own_of_one}}\n{body}\n")
    (tmp_path / "other.yaml").write_text(f"format: stretch-tree/1\n{body}\n")
    (tmp_path / "sweep.yaml").write_text("format: stretch-sweep/1\ntree: [one.yaml, other.yaml]\n")
    with apart():
        found = check_sweep(tmp_path / "sweep.yaml").diagnostics
    assert [(d.code, d.line, d.column) for d in found] == [("tree-wrong", 2, 18)]
