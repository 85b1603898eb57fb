"""Every task runs again from wherever the one before left the hand, and over an empty table it ends with its reason and the hand raised."""

import json
from pathlib import Path

import pytest
import yaml

import stretch_bt

SHIPPED = Path(stretch_bt.__file__).parent / "trees"
CELL = SHIPPED / "cells" / "simulated.yaml"
ONE = {"diameters": [0.02], "stretches": [0.02], "trials": 1}
#: by task: what brings it to an end soon
TASKS = {
    "palpate_stiffness": {},
    "palpate_active": {},
    "reconstruct": {},
    "form_cookie": {},
    "form_cookie_fast": {},
    "characterize": {**ONE, "depths": [0.003, 0.008]},
    "contact_sensitivity": {**ONE, "depths": [0.0, 0.006, 0.011]},
}
#: in the default run
QUICK_EMPTY = ["form_cookie", "palpate_stiffness"]
#: under which there always is an indenter
MOUNTED = {"characterize", "contact_sensitivity"}
EMPTY = """\
format: stretch-scene/1
fidelity: hertz
object: {type: sphere, diameter: 20 mm, rigid: true, position: {x: 250 mm}}
"""


@pytest.fixture
def left_at(tmp_path):
    """Return a simulated cell whose hand is at first where a record says that it was sent last."""

    def write(record):
        text = CELL.read_text()
        if record is not None:
            x, y, z = last_target(record)["position"]
            text = text.replace("height: 120 mm}", f"x: {x} m, y: {y} m, height: {z} m}}", 1)
        path = tmp_path / "left.yaml"
        path.write_text(text)
        return path

    return write


def last_target(record):
    """Return the last pose that the arm was sent to."""
    events = [json.loads(line) for line in (Path(record) / "events.jsonl").read_text().splitlines()]
    sent = [
        e["arguments"] for e in events if e.get("type") == "command" and e["device"] == "arm" and e["name"] != "stop"
    ]
    return sent[-1].get("target") or sent[-1]["path"][-1]


@pytest.mark.slow
@pytest.mark.parametrize("tree", TASKS)
def test_a_task_runs_three_times_in_a_row(run, left_at, tree):
    record, scene = None, yaml.safe_load((SHIPPED / f"{tree}.yaml").read_text())["scene"]
    for _ in range(3):
        result = run(tree, cell=left_at(record), scene=scene, params=TASKS[tree])
        assert result.status == "SUCCESS", result.reason
        record = result.record


@pytest.mark.parametrize(
    "tree",
    [
        pytest.param(tree, marks=[pytest.mark.slow] * (tree not in QUICK_EMPTY))
        for tree in sorted(TASKS.keys() - MOUNTED)
    ],
)
def test_over_an_empty_table_a_task_fails_with_its_reason_and_raises_the_hand(run, hand_at, tmp_path, tree):
    scene = tmp_path / "empty.yaml"
    scene.write_text(EMPTY)
    result = run(tree, cell=hand_at(40), scene=scene)
    assert (result.status, "nothing was met down to 0 mm" in result.reason) == ("FAILURE", True), result.reason
    assert last_target(result.record)["position"][2] == pytest.approx(0.020)
