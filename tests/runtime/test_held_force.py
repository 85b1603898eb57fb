"""A limit of force that nothing in a cell can hold is found before anything moves."""

import json

import pytest
from typer.testing import CliRunner

from stretch_bt.cli.app import app

ARM = """\
format: stretch-cell/1
devices:
  arm:
    type: Arm
    use: {use}
    host: 192.168.1.10
    model: {model}
    base: {{x: -500 mm}}
    hand: {{z: 300 mm, rx: 180 deg}}
    source: an example
"""
SIMULATED = "format: stretch-cell/1\ndevices:\n  arm: {type: Arm, use: simulated}\n"
SENSOR = "  felt: {type: ForceSensor, use: simulated}\n"
TREE = """\
format: stretch-tree/1
devices: {{arm: Arm{sensor}}}
keys: {{h: Length, most: Force, touch: Touch}}
trees:
  main:
    {body}
"""
ROLL = "roll: {speed: 10 mm/s, max_force: %s}"
THINNER = "press_to_thickness: {thickness: 10 mm, max_force: %s}"


def written_body(body):
    """Return a body in which first contact counts as known."""
    steps = body.removeprefix("sequence: [").removesuffix("]")
    return f"sequence: [set: {{touch: none}}, {steps}]"


@pytest.fixture
def findings(tmp_path):
    """Return what `check` says of forces in a tree and a cell."""

    def check(body, cell, *, sensor=False):
        (tmp_path / "cell.yaml").write_text(cell)
        text = TREE.format(body=written_body(body), sensor=", felt: ForceSensor" if sensor else "")
        (tmp_path / "tree.yaml").write_text(text)
        command = ["check", str(tmp_path / "tree.yaml"), "--cell", str(tmp_path / "cell.yaml"), "--json"]
        done = CliRunner().invoke(app, command)
        found = [d for d in json.loads(done.stdout) if "too noisy" in d["message"]]
        assert done.exit_code == 2 or not found
        return found

    return check


def ur(model, limits="force: 20 N"):
    return ARM.format(use="ur", model=model) + f"limits: {{{limits}, contact: {{below: 100 mm, speed: 30 mm/s}}}}\n"


# (model, limit, whether it is refused): noise leaves 3 N to a CB3 and a quarter of one to an e-series
NOISE = [
    ("ur5", "2.9 N", True),
    ("ur5", "0.5 N", True),
    ("ur5", "3 N", False),
    ("ur5", "5 N", False),
    ("ur5e", "1 N", False),
    ("ur5e", "0.2 N", True),
]


@pytest.mark.parametrize(("model", "limit", "refused"), NOISE)
@pytest.mark.parametrize("body", [ROLL, "sequence: [set: {most: %s}, roll: {speed: 10 mm/s, max_force: $most}]"])
def test_a_limit_under_the_noise_of_the_arm_is_refused_where_it_is_written(findings, body, model, limit, refused):
    found = findings(body % limit, ur(model))
    known = "$most" not in body  # else the run alone knows it, and refuses it
    assert len(found) == (refused and known)
    for finding in found:
        line = TREE.format(body=written_body(body % limit), sensor="").splitlines()[finding["line"] - 1]
        assert line[finding["column"] - 1 :].startswith(limit)
        assert (finding["severity"], finding["code"]) == ("error", "cell-limit")
        assert "force of 'arm' is too noisy to hold less than" in finding["message"]
        assert finding["hint"].startswith("declare a force sensor in the tree and the cell")


@pytest.mark.parametrize("body", [ROLL, "press: {depth: 2 mm, max_force: %s}"])
def test_a_force_sensor_of_tree_and_cell_holds_it(findings, body):
    cell = ur("ur5").replace("limits:", SENSOR + "limits:")
    assert findings(body % "1 N", cell, sensor=True) == []
    assert findings(body % "1 N", cell)
    assert findings(body % "1 N", SIMULATED) == []


@pytest.mark.parametrize(
    ("model", "limit", "refused"),
    [("ur5", "4.9 N", True), ("ur5", "5 N", False), ("ur5e", "1.6 N", True), ("ur5e", "1.7 N", False)],
)
def test_a_limit_of_the_cell_under_the_noise_is_refused_in_its_file(findings, model, limit, refused):
    found = findings(ROLL % "1 N", ur(model, f"force: {limit}"))
    own = [finding for finding in found if finding["file"].endswith("cell.yaml")]
    assert len(own) == refused
    for finding in own:
        assert (finding["line"], finding["column"]) == (11, 17)
        assert finding["code"] == "out-of-bounds"
        assert "N or more" in finding["hint"]


def test_a_call_with_another_arm_is_held_against_that_arm(tmp_path):
    left, arm = ur("ur5"), ur("ur5e")
    cell = arm.replace(
        "limits:", left[left.index("  arm:") : left.index("limits:")].replace("arm:", "left:", 1) + "limits:"
    )
    (tmp_path / "cell.yaml").write_text(cell.replace("192.168.1.10", "192.168.1.11", 1))
    (tmp_path / "lib.yaml").write_text(
        "format: stretch-tree/1\ntrees: {go: {keys: {touch: Touch}, sequence: [set: {touch: none}, press: {depth: 2 mm, max_force: 1 N}]}}\n"
    )
    for name, refused in (("left", True), ("arm", False)):
        (tmp_path / "tree.yaml").write_text(
            "format: stretch-tree/1\nimports: {lib: lib.yaml}\ndevices: {arm: Arm, left: Arm}\n"
            f"trees: {{main: {{sequence: [lib.go: {{arm: {name}}}, wait: {{duration: 1 s}}]}}}}\n"
        )
        done = CliRunner().invoke(
            app, ["check", str(tmp_path / "tree.yaml"), "--cell", str(tmp_path / "cell.yaml"), "--json"]
        )
        found = [d["message"] for d in json.loads(done.stdout) if "too noisy" in d["message"]]
        assert len(found) == refused, done.stdout
        assert all("'left'" in message for message in found)
