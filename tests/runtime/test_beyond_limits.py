"""A plan that would pass a limit of the cell is a FAILURE that a tree can catch: nothing moves, and port and limit are named."""

import json
from pathlib import Path

import pytest
import yaml

import stretch_bt
from stretch_bt import run

CELLS = Path(stretch_bt.__file__).parent / "trees" / "cells"
LIMITS = {
    "x": {"min": "-50 mm", "max": "50 mm"},
    "y": {"min": "-50 mm", "max": "50 mm"},
    "height": {"min": "30 mm", "max": "130 mm"},
    "speed": "100 mm/s",
    "gripper_speed": "50 mm/s",
    "depth": "8 mm",
    "stretch": {"min": "0 mm", "max": "40 mm"},
    "force": "20 N",
    "contact": {"below": "110 mm", "speed": "20 mm/s"},
}
#: what to do about a command to the fingers
REMEDY = "ask for a value within, or change `{}` under `limits` in the cell file"
#: node -> what its reason begins with
BEYOND = {
    "set_stretch: {stretch: 41 mm}": "gripper: stretch 41 mm is past the limits of the cell, 0 mm to 40 mm; "
    + REMEDY.format("stretch"),
    "set_stretch: {stretch: 10 mm, speed: 60 mm/s}": "gripper: speed 60 mm/s is past the limit of the cell, at most 50 mm/s; "
    + REMEDY.format("gripper_speed"),
    "press: {depth: 9 mm}": "arm: depth 9 mm is past the limit of the cell, at most 8 mm",
    "press: {depth: 5 mm, speed: 30 mm/s}": "arm: speed 30 mm/s is past the limit of the cell, at most 20 mm/s below",
    "roll: {radius: 60 mm, depth: 2 mm, laps: 1, speed: 10 mm/s}": "arm: radius: ",
    "move_over: {x: 60 mm, y: 0 mm}": "arm: x 60 mm is past the limits of the cell, -50 mm to 50 mm",
}
TREE = """\
format: stretch-tree/1
devices: {{arm: Arm, gripper: Gripper, camera: DepthCamera}}
scene: calibration_cylinder
trees:
  main:
    out: {{caught: bool}}
    sequence:
      - approach: {{speed: 20 mm/s}}
      - selector:
          - sequence: [{{{node}}}, set: {{caught: false}}]
          - set: {{caught: true}}
"""


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    """The simulated cell with tight limits."""
    made = yaml.safe_load((CELLS / "simulated.yaml").read_text("utf-8"))
    path = tmp_path_factory.mktemp("cell") / "tight.yaml"
    path.write_text(yaml.safe_dump({**made, "limits": LIMITS}), "utf-8")
    return path


#: whose limit is met as another of them
ALIKE = (
    "set_stretch: {stretch: 10 mm, speed: 60 mm/s}",
    "press: {depth: 9 mm}",
    "press: {depth: 5 mm, speed: 30 mm/s}",
    "move_over: {x: 60 mm, y: 0 mm}",
)


@pytest.mark.parametrize("node", [pytest.param(n, marks=[pytest.mark.slow] * (n in ALIKE)) for n in BEYOND])
def test_a_plan_beyond_a_limit_fails_by_its_port_and_the_tree_goes_on(cell, at_hertz, tmp_path, node):
    quick = at_hertz("calibration_cylinder", tmp_path)
    tree, name = tmp_path / "tree.yaml", node.partition(":")[0]
    tree.write_text(TREE.format(node=node), "utf-8")
    result = run(tree, cell=cell, scene=quick, out=tmp_path / "record")
    assert (result.status, result.outputs["caught"]["value"]) == ("SUCCESS", True), result.reason
    events = [json.loads(line) for line in (tmp_path / "record" / "events.jsonl").read_text("utf-8").splitlines()]
    own = [event for event in events if event.get("path", event.get("owner", "")).endswith(f"/{name}")]
    assert [event["type"] for event in own] == ["status"], "it commanded nothing"
    assert own[0]["status"] == "FAILURE"
    assert own[0]["reason"].startswith(BEYOND[node])
