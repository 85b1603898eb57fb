"""Words of the command line that no command should take."""

import json

import pytest


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "palpate_stiffness", "--cell", ""), "--cell is empty"),
        (("run", "palpate_stiffness", "--scene="), "--scene is empty"),
        (("run", "palpate_stiffness", "--out", ""), "--out is empty"),
        (("run", ""), "an argument is empty"),
        (("check", ""), "an argument is empty"),
    ],
)
def test_a_variable_that_is_not_set_is_no_default(cli, tmp_path, monkeypatch, words, said):
    """An empty --cell ran the twin in silence."""
    monkeypatch.chdir(tmp_path)
    code, _, err = cli(*words)
    assert code == 2
    assert said in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("format_", "taker"),
    [
        ("stretch-mocks/1", "--mocks"),
        ("stretch-scene/1", "--scene"),
        ("stretch-cell/1", "--cell"),
        ("stretch-sweep/1", "sweep"),
    ],
)
def test_a_file_of_another_kind_is_named_with_who_takes_it(cli, tmp_path, format_, taker):
    """The error once said to write 'stretch-tree/1', and then that every key is wrong."""
    path = tmp_path / "other.yaml"
    path.write_text(f"format: {format_}\ndevices: {{a: b}}\nexpect: {{}}\n")
    code, _, err = cli("run", str(path))
    assert code == 2
    assert "not a tree" in err
    assert taker in err
    assert "device-type" not in err


@pytest.mark.parametrize(
    ("words", "format_", "said"),
    [
        (("doctor", "other.yaml"), "stretch-tree/1", "this is a tree, and a cell is wanted"),
        (("sweep", "other.yaml"), "stretch-cell/1", "this is a cell, and a sweep is wanted"),
        (
            ("run", "watch_contact", "--scene", "other.yaml"),
            "stretch-mocks/1",
            "this is a mocks file, and a scene is wanted",
        ),
    ],
)
def test_where_another_kind_is_wanted_that_alone_is_told(cli, tmp_path, words, format_, said):
    """Where a cell was wanted, the error once suggested its format, and then named each key of a tree as unknown."""
    (tmp_path / "other.yaml").write_text(f"format: {format_}\ntick: 10 ms\nnothing: 1\n")
    code, _, err = cli(*words)
    assert code == 2
    assert said in err
    assert "unknown key" not in err


@pytest.mark.parametrize("name", ["press", "wait", "sequence"])
def test_a_new_node_has_a_name_of_its_own(cli, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    code, _, err = cli("new", "node", name)
    assert code == 2
    assert f"my_{name}" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("run", "palpate_stiffness", "--seed", "abc", "--json"),
            "'--seed': it takes a whole number, not 'abc'; write",
        ),
        (("run", "palpate_stiffness", "--seed", "1e3", "--json"), "it takes a whole number, not '1e3'"),
        (("run", "palpate_stiffness", "--seed", "-1", "--json"), "'--seed': -1 is out of bounds; write at least 0"),
        (("nodes", "--jsn", "--json"), "No such option: --jsn"),
        (("frobnicate", "--json"), "No such command 'frobnicate'"),
        (("accuracy", "runner", "--json", "--page", "file"), "move it away"),
    ],
)
def test_the_json_of_what_is_refused_says_why(cli, tmp_path, monkeypatch, words, said):
    """It said that standard error says why."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    code, out, _ = cli(*words)
    assert code == 2
    assert said in json.loads(out)["reason"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("show", "palpate_stiffness", "--out", "folder"), "it is a folder; name a file in it"),
        (("show", "palpate_stiffness", "--out", "file/tree.svg"), "a file is where a folder is wanted"),
        (
            ("show", "palpate_stiffness", "--out", "there/tree"),
            "there/tree: No such file or directory; correct the name",
        ),
        (("show", "palpate_stiffness", "--format", "svg", "--wires"), "--wires belongs to the text form"),
        (("show", "--wires", "svg"), "'svg' is a format, not a tree; write 'stretch-bt show TREE --format svg'"),
        (
            ("show", "palpate_stiffness", "--wires", "--format", "pdf"),
            "there is no format 'pdf'; known here: btcpp, dot,",
        ),
        (("show", "palpate_stiffness", "--out", "t.svg", "--wires"), "--wires belongs to the text form, not to svg"),
        (
            ("show", "palpate_stiffness", "--out", "tree.xyz"),
            "or .xml; write a name such as tree.svg, or name its format",
        ),
        (("move", "simulated", "--up", "10"), "--up: 10 has no unit; write '10 mm'"),
        (("move", "simulated", "--up", "10 mm", "--speed", "1 m"), "--speed: 1 m is Length, not Speed"),
        (("press", "--indenter", "sphere:20mm", "--stretch", "0 mm", "--depth", "5"), "--depth: 5 has no unit"),
        (
            ("press", "--indenter", "sphere:20mm", "--stretch", "0 mm", "--depth", "5 mm", "--at", "3"),
            "--at: '3' is not a pair",
        ),
        (("new", "sweep", "mine"), "docs/sweeps.md has one to copy"),
    ],
)
def test_what_the_system_refuses_has_a_remedy(cli, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    code, _, err = cli(*words)
    assert code == 2
    assert said in err


@pytest.mark.parametrize(
    ("words", "begins"),
    [
        (("--out", "t.svg"), "<svg"),
        (("--out", "t.SVG"), "<svg"),
        (("--out", "t.gv"), "digraph"),
        (("--out", "t.htm"), "<!DOCTYPE html>"),
        (("--out", "t.xml"), "<root BTCPP_format"),
        (("--out", "t"), "\ntick "),
        (("--out", "t.txt", "--wires"), "\ntick "),
        (("--out", "t.svg", "--format", "text"), "\ntick "),
        (("--out", "t.xyz", "--format", "dot"), "digraph"),
    ],
)
def test_a_tree_is_written_as_the_name_of_its_file_ends(cli, tmp_path, words, begins):
    """Plain text was written into an .svg."""
    code, _, err = cli("show", "watch_contact", *words[:1], str(tmp_path / words[1]), *words[2:])
    assert (code, err) == (0, "")
    assert begins in (tmp_path / words[1]).read_text()[:200]


@pytest.mark.parametrize(
    ("name", "said"), [("press.svg", "does not end in a picture format"), ("there/p.png", "make it first")]
)
def test_a_picture_that_cannot_be_written_is_told_before_anything_is_solved(cli, tmp_path, monkeypatch, name, said):
    """The error once came after 12 to 26 s."""
    monkeypatch.setattr("stretch_bt.simulation.press", lambda *given, **more: pytest.fail("it was solved"))
    words = ("press", "--indenter", "sphere:20mm", "--stretch", "30mm", "--depth", "8mm")
    code, _, err = cli(*words, "--plot", str(tmp_path / name))
    assert code == 2
    assert said in err


OWN_GRIPPER = '''\
from stretch_bt.devices import GripperDriver, MotionState, Reading


class Fingers(GripperDriver):
    """Fingers that are nowhere."""

    def move(self, opening, speed):
        return lambda: MotionState.DONE

    def opening(self):
        return Reading(0.055, self.now(), self.now(), 0)
'''


@pytest.mark.parametrize(
    ("devices", "said"),
    [
        ("{camera: {type: DepthCamera, use: simulated}}", "own.yaml has no gripper; name a cell with one"),
        ("{g: {type: Gripper, use: fingers}}", "g needs no activation: its driver, Fingers, has none"),
        (
            "{g: {type: Gripper, use: fingers}, h: {type: Gripper, use: fingers}}",
            "own.yaml has the grippers g, h; name one with --device",
        ),
    ],
)
def test_what_cannot_be_activated_is_told(cli, tmp_path, devices, said):
    """A gripper without an activation was once reported as activated, and a missing gripper as none 'of that name'."""
    (tmp_path / f"{tmp_path.name}.py").write_text(OWN_GRIPPER)
    cell = tmp_path / "own.yaml"
    cell.write_text(f"format: stretch-cell/1\nimports: {{own: {tmp_path.name}}}\ndevices: {devices}\n")
    code, _, err = cli("activate", str(cell), "--yes")
    assert code == 2
    assert said in " ".join(err.split())
