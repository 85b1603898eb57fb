"""The command line as scripts see it: one JSON document, exit codes, no traceback for a user's mistake."""

import json
import math
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import stretch_bt.cli
from stretch_bt.cli.commands import Commands, Group
from stretch_bt.hardware.implementations import SHIPPED
from stretch_bt.tree.flow import CONSTRUCTS

MOCKS = Path(__file__).parents[1] / "trees" / "mocks"


RUN_FIELDS = {"status", "reason", "outputs", "truth", "ticks", "task_seconds", "wall_seconds", "cpu_seconds", "record"}


@pytest.mark.parametrize(
    ("tree", "mocks", "code", "status"),
    [
        ("palpate_stiffness", "palpate_stiffness_success", 0, "SUCCESS"),
        ("palpate_stiffness", "palpate_stiffness_failure", 1, "FAILURE"),
        ("watch_contact", "watch_contact_success", 0, "SUCCESS"),
    ],
)
def test_run_prints_one_document(cli, tmp_path, tree, mocks, code, status):
    exit_code, out, _ = cli("run", tree, "--mocks", MOCKS / f"{mocks}.yaml", "--json", "--out", "record")
    result = json.loads(out)
    assert (exit_code, result["status"]) == (code, status)
    assert result.keys() >= RUN_FIELDS
    assert result["record"] == str(tmp_path / "record")
    assert {"run.json", "events.jsonl", "record.mcap", "result.json", "report.html"} == {
        p.name for p in (tmp_path / "record").iterdir()
    }
    for output in result["outputs"].values():
        assert output.keys() == {"value", "unit", "sd"}


def test_a_run_without_a_record_says_null(cli, tmp_path):
    mocks = MOCKS / "watch_contact_success.yaml"
    code, out, _ = cli("run", "watch_contact", "--mocks", mocks, "--json", "--record", "none", "--quiet")
    assert (code, json.loads(out)["record"]) == (0, None)
    code, out, _ = cli("run", "watch_contact", "--mocks", mocks, "--record", "none", "--quiet")
    assert "record:" not in out
    assert list(tmp_path.iterdir()) == []


def test_run_for_a_person_names_the_failed_node_and_why(cli):
    code, out, err = cli("run", "palpate_stiffness", "--mocks", MOCKS / "palpate_stiffness_failure.yaml")
    assert code == 1
    assert "main/feel_first/fit_sphere: the cap carries no convex radius" in out
    assert "main/feel_first/fit_sphere" in err  # the live view


def test_replay_of_a_record(cli, tmp_path):
    cli("run", "watch_contact", "--mocks", MOCKS / "watch_contact_success.yaml", "--out", "record", "-q")
    code, out, _ = cli("replay", "record", "--json")
    assert code == 0
    result = json.loads(out)
    assert result["identical"] is True
    assert result["first_difference"] is None
    assert result["decisions"] > 20
    events = (tmp_path / "record" / "events.jsonl").read_text()
    (tmp_path / "record" / "events.jsonl").write_text(events.replace('"value":0.002', '"value":0.0021'))
    code, out, _ = cli("replay", "record", "--json")
    assert code == 1
    assert json.loads(out)["first_difference"].keys() == {"tick", "node", "recorded", "replayed"}


def test_the_record_folder_must_be_empty(cli, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    code, out, _ = cli(
        "run", "watch_contact", "--mocks", MOCKS / "watch_contact_success.yaml", "--out", "full", "--json"
    )
    assert code == 2
    assert json.loads(out)["status"] == "ERROR"
    assert [p.name for p in (tmp_path / "full").iterdir()] == ["mine.txt"]


BAD = [
    (["run", "palpate_stifness"], "did you mean 'palpate_stiffness'"),
    (["run", "palpate_stiffness", "--set", "wanted_deflectio=2mm"], "did you mean 'wanted_deflection'"),
    (["run", "palpate_stiffness", "--set", "wanted_deflection=2"], "2 mm"),
    (["run", "palpate_stiffness", "--set", "wanted_deflection=200mm"], "10 mm"),
    (["run", "palpate_stiffness", "--set", "depth"], "--set depth=2mm"),
    (["run", "palpate_stiffness", "--set", "max_force=3N", "--set", "max_force=4N"], "set to '3N' and to '4N'"),
    (["run", "palpate_stiffness", "--scene", "water_baloon"], "water_balloon"),
    (["run", "palpate_stiffness", "--cell", "simulatd"], "simulated"),
    (["run", "palpate_stiffness", "--mocks", "nothing.yaml"], "no such file"),
    (["run", "palpate_stiffness", "--seed", "x"], "--seed"),
    (["nodes", "pres"], "press"),
    (["schema", "trees"], "tree"),
    (["show", "palpate_stiffness", "--format", "pdf"], "svg"),
    (["replay", "nowhere"], "no such folder"),
    (["report", "nowhere"], "no such folder"),
    (["check", "nowhere.yaml"], "no such file"),
    (["new", "tre", "mine"], "tree"),
    (["press", "--indenter", "ball:20mm", "--stretch", "30mm", "--depth", "10mm"], "sphere"),
    (["press", "--indenter", "sphere:20mm", "--stretch", "30", "--depth", "10mm"], "30 mm"),
    (["press", "--indenter", "cube:1mm", "--stretch", "30mm", "--depth", "3mm"], "a side of at least 2 mm"),
    (["press", "--indenter", "cylinder:1mm", "--stretch", "30mm", "--depth", "3mm"], "as in cylinder:1mm:0.25mm"),
    (["press", "--indenter", "sphere:20mm", "--stretch", "30mm", "--depth", "10mm", "--at", "5mm"], "pair"),
    (["new", "tree", "My Tree"], "small letters"),
    (["new", "device", "mine"], "--kind Arm, Gripper, DepthCamera, ForceSensor"),
    (["new", "device", "mine", "--kind", "Griper"], "--kind Gripper"),
    (["new", "tree", "mine", "--kind", "Arm"], "leave --kind out"),
    (["new", "node", "mine", "--kind", "perceptive"], "--kind perception"),
    (["new", "node", "mine", "--kind", "Arm"], "--kind model, perception, actuation"),
    (["frobnicate"], "frobnicate"),
]


@pytest.mark.parametrize(("arguments", "said"), BAD, ids=[" ".join(a) for a, _ in BAD])
def test_bad_input_is_exit_2_with_what_to_write_instead(cli, arguments, said):
    code, out, err = cli(*arguments)
    assert code == 2, err
    assert said in " ".join((out + err).split())
    assert "Traceback" not in out + err


def test_check_json_is_the_contract(cli, tmp_path):
    (tmp_path / "a.yaml").write_text("format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - pres: {}\n")
    code, out, _ = cli("check", "a.yaml", "--json")
    assert code == 2
    [finding] = json.loads(out)
    assert finding == {
        "file": "a.yaml",
        "line": 5,
        "column": 9,
        "severity": "error",
        "code": "node-unknown",
        "message": finding["message"],
        "hint": "did you mean 'press'?",
    }
    (tmp_path / "b.yaml").write_text(
        "format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - wait: {duration: 1 s}\n"
    )
    assert cli("check", "b.yaml", "--json")[:2] == (0, "[]\n")


def test_check_for_a_person_shows_the_line(cli, tmp_path):
    (tmp_path / "a.yaml").write_text("format: stretch-tree/1\ntrees:\n  main:\n    sequence:\n      - pres: {}\n")
    _, out, _ = cli("check", "a.yaml")
    assert "    5 |       - pres: {}\n      |         ^^^^\n" in out


def test_nodes_of_a_tree_are_listed_with_it_alone(cli, tmp_path):
    (tmp_path / "rubbing.py").write_text(
        '"""Own."""\nfrom stretch_bt.tree.ports import Behavior\nfrom stretch_bt.tree.registry import node\n\n'
        '@node\nclass RubGently(Behavior):\n    """Rub."""\n'
    )
    tree = tmp_path / "rub.yaml"
    tree.write_text("format: stretch-tree/1\nimports: {own: rubbing}\ntrees: {main: {sequence: [fail: no]}}\n")
    assert cli("nodes", "rub_gently")[0] == 2
    [own] = json.loads(cli("nodes", "rub_gently", "--tree", tree, "--json")[1])
    assert (own["name"], own["doc"]) == ("rub_gently", "Rub.")
    tree.write_text("format: stretch-tree/1\nimports: {own: rabbing}\ntrees: {main: {sequence: [fail: no]}}\n")
    code, _, err = cli("nodes", "--tree", tree)
    assert code == 2
    assert "rabbing" in err


@pytest.mark.parametrize("name", CONSTRUCTS)
def test_nodes_says_what_each_construct_takes(cli, name):
    [found] = json.loads(cli("nodes", name, "--json")[1])
    [press] = json.loads(cli("nodes", "press", "--json")[1])
    assert found.keys() == press.keys()
    assert (found["name"], found["kind"]) == (name, "construct")
    code, out, _ = cli("nodes", name)
    assert code == 0
    assert all(field["name"] in out for field in found["inputs"])


def test_brackets_and_colons_of_a_node_are_shown_as_they_are(cli, tmp_path):
    (tmp_path / "bracketed.py").write_text(
        '"""Own."""\nfrom stretch_bt import Behavior, In, Out\nfrom stretch_bt.tree.registry import node\n\n'
        '@node\nclass Bracketed(Behavior):\n    """Give x[/i] at :x: or [red]."""\n'
        "    weights: In[list[float]]  # of w[/i], :x:\n    marks: Out[list[int]]\n"
    )
    (tmp_path / "t.yaml").write_text(
        "format: stretch-tree/1\nimports: {own: bracketed}\ntrees: {main: {sequence: [fail: no]}}\n"
    )
    for words in (["nodes", "bracketed"], ["nodes"]):
        code, out, err = cli(*words, "--tree", "t.yaml")
        assert (code, "x[/i] at :x: or [red]." in out) == (0, True), err
    out = cli("nodes", "bracketed", "--tree", "t.yaml")[1]
    assert all(text in out for text in ("list[float]", "list[int]", "of w[/i], :x:"))


def test_an_output_with_brackets_is_shown_as_it_is(cli, tmp_path):
    (tmp_path / "t.yaml").write_text(
        "format: stretch-tree/1\ntrees: {main: {out: [word], sequence: [set: {word: '\"a[/b] [red] :x:\"'}]}}\n"
    )
    code, out, err = cli("run", "t.yaml", "--record", "none", "--quiet")
    assert (code, "a[/b] [red] :x:" in out) == (0, True), err


def test_nodes_says_what_a_function_is(cli):
    code, _, err = cli("nodes", "median")
    assert code == 2
    assert "function of expressions" in err


def test_nodes_json_is_the_contract(cli):
    nodes = json.loads(cli("nodes", "--json")[1])
    assert {"press", "fit_sphere", "set_stretch", "approach", "check", "set"} <= {n["name"] for n in nodes}
    [press] = json.loads(cli("nodes", "press", "--json")[1])
    assert press.keys() >= {"name", "kind", "doc", "module", "inputs", "outputs"}
    depth = next(p for p in press["inputs"] if p["name"] == "depth")
    assert depth.keys() >= {"name", "type", "unit", "default", "required", "doc"}
    assert (depth["type"], depth["unit"], depth["required"]) == ("Length", "m", True)


@pytest.mark.parametrize("kind", ["tree", "scene", "cell", "mocks"])
def test_schema_is_json(cli, kind):
    code, out, _ = cli("schema", kind)
    assert code == 0
    assert json.loads(out)["type"] == "object"


@pytest.mark.parametrize("kind", ["tree", "scene", "cell", "mocks"])
def test_new_files_check_clean_and_are_not_overwritten(cli, tmp_path, kind):
    assert cli("new", kind, "mine")[0] == 0
    assert cli("check", "mine.yaml", "--json")[:2] == (0, "[]\n")
    before = (tmp_path / "mine.yaml").read_text()
    assert cli("new", kind, "mine")[0] == 2
    assert (tmp_path / "mine.yaml").read_text() == before


@pytest.mark.parametrize("kind", ["Arm", "Gripper", "DepthCamera", "ForceSensor"])
def test_a_new_device_checks_clean_and_writes_all_of_its_files_or_none(cli, tmp_path, kind):
    (tmp_path / "test_mine.py").write_text("mine")
    assert cli("new", "device", "mine", "--kind", kind)[0] == 2
    assert [path.name for path in tmp_path.iterdir()] == ["test_mine.py"]
    name = f"own_{kind.lower()}"  # one module has a name in a process
    assert cli("new", "device", name, "--kind", kind)[0] == 0
    assert cli("check", f"{name}.yaml", "--json")[:2] == (0, "[]\n")
    assert (tmp_path / f"test_{name}.py").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["device", "wrench", "--kind", "ForceSensor"],
            "the class Wrench would hide another Wrench that wrench.py needs",
        ),
        (["device", "link", "--kind", "Gripper"], "the class Link would hide another Link"),
        (["device", "motion_state", "--kind", "Arm"], "the class MotionState would hide"),
        (["node", "status"], "the class Status would hide another Status that status.py needs"),
        (["device", "time", "--kind", "Gripper"], "time.py would have the name of an installed Python module"),
        (["node", "numpy"], "numpy.py would have the name of an installed Python module"),
        (["device", "none", "--kind", "Arm"], "'none' has a meaning of its own"),
        (["node", "class"], "'class' has a meaning of its own"),
        (["device", "null", "--kind", "Arm"], "'null' has a meaning of its own"),
        *(
            (["device", use, "--kind", kind], f"'{use}' is the name of a shipped {kind}")
            for kind, use in SHIPPED
            if kind != "Operator"
        ),
    ],
)
def test_a_new_module_takes_the_place_of_nothing(cli, tmp_path, words, said):
    code, out, err = cli("new", *words)
    assert code == 2
    assert said in out + err
    assert f"choose another name, such as my_{words[1]}" in out + err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "instead"), [("fit_2d", "fit2d"), ("move_x_y", "move_xy"), ("softness_", "softness")])
def test_a_new_node_has_the_name_that_trees_write(cli, tmp_path, name, instead):
    code, out, err = cli("new", "node", name)
    assert (code, list(tmp_path.iterdir())) == (2, [])
    assert f"would be the node '{instead}', not '{name}'; choose another name, such as {instead}" in out + err
    assert cli("new", "node", instead)[0] == 0


def test_a_new_node_runs_in_a_tree(cli, tmp_path):
    assert cli("new", "node", "softness")[0] == 0
    (tmp_path / "t.yaml").write_text(
        "format: stretch-tree/1\nimports: {own: softness}\nkeys: {}\ntrees:\n  main:\n    out: {k: Stiffness}\n    sequence:\n"
        "      - softness: {force: 1 N, force_sd: 0.1 N, deflection: 2 mm, deflection_sd: 0.1 mm, stiffness: $k}\n"
    )
    command = [sys.executable, "-m", "stretch_bt", "run", "t.yaml", "--json", "-q"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    sd = pytest.approx(math.hypot(0.1, 0.5 * 0.1) / 2)
    assert json.loads(done.stdout)["outputs"]["k"] == {"value": 0.5, "unit": "N/mm", "sd": sd}


def test_new_nodes_of_other_kinds_see_and_move(cli, at_hertz, tmp_path):
    scene = at_hertz("calibration_sphere", tmp_path).name
    assert cli("new", "node", "mean_height", "--kind", "perception")[0] == 0
    assert cli("new", "node", "nudge_hand", "--kind", "actuation")[0] == 0
    (tmp_path / "t.yaml").write_text(
        "format: stretch-tree/1\nimports: {see: mean_height, do: nudge_hand}\n"
        f"devices: {{arm: Arm, gripper: Gripper, camera: DepthCamera}}\nscene: {scene}\n"
        "trees:\n  main:\n    out: [mean_height]\n    sequence:\n"
        "      - approach: {speed: 40 mm/s}\n      - press: {depth: 8 mm}\n      - average_frames\n      - segment_contact\n"
        "      - mean_height: {mean_height}\n      - nudge_hand: {distance: 2 mm}\n    finally: [retract]\n"
    )
    command = [sys.executable, "-m", "stretch_bt", "run", "t.yaml", "--json", "-q"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    height = json.loads(done.stdout)["outputs"]["mean_height"]
    assert 6 < height["value"] < 8.1
    assert 0 < height["sd"] < 0.2


def test_a_new_mocks_file_runs_its_tree(cli):
    assert cli("new", "mocks", "quick")[0] == 0
    code, out, _ = cli("run", "palpate_stiffness", "--mocks", "quick.yaml", "--set", "last_deflection=1.5 mm", "--json")
    assert (code, json.loads(out)["status"]) == (0, "SUCCESS")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_with_130_and_a_whole_record(tmp_path, number):
    command = [sys.executable, "-m", "stretch_bt", "run", "palpate_stiffness", "--json", "--out", "record"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ
    )
    for line in process.stderr:  # the arm is on its way down
        if "main/approach" in line:
            break
    process.send_signal(number)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    assert json.loads(out)["status"] == "INTERRUPTED"
    assert json.loads((tmp_path / "record" / "result.json").read_text())["status"] == "INTERRUPTED"


def test_help_names_every_command(cli):
    _, out, _ = cli("--help")
    for command in Commands(stretch_bt.cli):
        assert f" {command} " in out


def test_a_command_that_cannot_be_made_is_not_one_that_was_misspelt(monkeypatch):
    def broken(name, module):
        raise KeyError(module)

    monkeypatch.setattr("stretch_bt.cli.commands._made", broken)
    with pytest.raises(KeyError, match="command_press"):
        Group(commands=Commands(stretch_bt.cli)).get_command(None, "press")


def test_press_json_is_the_contract(cli, tmp_path):
    wanted = ["--indenter", "sphere:20mm", "--stretch", "30 mm", "--depth", "10mm", "--shear-modulus", "40kPa"]
    code, out, _ = cli("press", *wanted, "--json", "--plot", "sheet.png")
    result = json.loads(out)
    assert code == 0
    assert result["force_N"] == pytest.approx(0.6074, rel=0.01)
    assert result["contact"].keys() == {"area_mm2", "radius_mm", "nodes"}
    assert result.keys() == {"force_N", "force_error_N", "contact", "balance", "iterations", "residual", "seconds"}
    assert (tmp_path / "sheet.png").stat().st_size > 1000


def test_press_says_that_the_mount_comes_on_top_of_the_gauge(cli):
    said = re.sub(r"\W+", " ", cli("press", "--help")[1])
    assert "Unstretched length of the membrane between the clamps mount prestretch comes on top" in said


def test_press_shows_its_warnings_beside_its_answer(cli):
    code, out, err = cli(
        "press", *["--indenter", "sphere:20mm", "--stretch", "30mm", "--depth", "2mm", "--mesh", "8mm", "--json"]
    )
    assert code == 0
    assert json.loads(out)["force_N"] > 0
    assert "finer mesh" in err


@pytest.mark.parametrize("solver", ["hertz", pytest.param("axisymmetric", marks=pytest.mark.slow)])
def test_press_states_no_error_of_a_model_whose_error_is_unknown(cli, solver):
    wanted = ["--indenter", "sphere:20mm", "--stretch", "30mm", "--depth", "10mm", "--solver", solver]
    code, out, err = cli("press", *wanted)
    assert (code, "error is not known" in out, "within" in out) == (0, True, False)
    assert "no error of the force is stated" in err
    _, out, _ = cli("press", *wanted, "--json")
    assert json.loads(out)["force_error_N"] is None


def test_press_without_an_answer_says_so(cli):
    code, out, _ = cli("press", "--indenter", "sphere:8mm", "--stretch", "80mm", "--depth", "60mm", "--json")
    assert code == 1
    assert json.loads(out).keys() == {"error", "reason"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["nodes", "pres"],
        ["replay", "nowhere"],
        ["press", "--indenter", "ball:1mm", "--stretch", "1mm", "--depth", "1mm"],
    ],
)
def test_bad_input_is_one_document_too(cli, arguments):
    code, out, _ = cli(*arguments, "--json")
    assert code == 2
    assert json.loads(out).keys() == {"error", "reason"}
