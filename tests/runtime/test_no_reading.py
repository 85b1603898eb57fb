"""An expression whose reading has no answer is FAILURE of its node, wherever it stands, and the tree goes on."""

import pytest

from stretch_bt import run
from stretch_bt.errors import NoEquilibrium
from stretch_bt.hardware.simulated.arm import SimulatedArm
from stretch_bt.runtime.replay import replay

TREE = """\
format: stretch-tree/1
devices: {{arm: Arm}}
scene: water_balloon
trees:
  main:
    selector:
      - {body}
      - sequence: [called: {{}}]
  called:
    sequence: [wait: {{duration: 0 s}}]
    finally: [wait: {{duration: 0 s}}]
"""
ASKS = "  asks: {sequence: [check: arm.force < 1 N]}\n"
BODIES = {
    "check": "{check: arm.force < 1 N}",
    "invert": "{invert: {check: arm.force < 1 N}}",
    "invert twice": "{invert: {invert: {check: arm.force < 1 N}}}",
    "invert of several": "{invert: {selector: [{check: arm.force < 1 N}, {check: arm.height < -9 m}]}}",
    "invert of a called tree": "{invert: {asks: {}}}",
    "guard": "{guard: {that: arm.force < 1 N, do: {wait: {duration: 1 s}}}}",
    "until": "{until: {that: arm.force < 1 N, max: 3, do: {wait: {duration: 0 s}}}}",
    "timeout": "{timeout: {after: arm.force / 1 N * 1 s, do: {wait: {duration: 1 s}}}}",
    "port": "{wait: {duration: arm.force / 1 N * 1 s}}",
}


@pytest.mark.parametrize("name", BODIES)
def test_what_has_no_answer_fails_and_the_next_branch_is_taken(tmp_path, monkeypatch, name):
    def refuse(*_):
        raise NoEquilibrium("nothing is in balance here")

    monkeypatch.setattr(SimulatedArm, "wrench", refuse)
    tree = tmp_path / "tree.yaml"
    tree.write_text(TREE.format(body=BODIES[name]) + (ASKS if "asks" in BODIES[name] else ""), "utf-8")
    result = run(tree, out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    lines = (tmp_path / "record" / "events.jsonl").read_text("utf-8").splitlines()
    assert any('"FAILURE"' in line and "nothing is in balance here" in line for line in lines)
    assert any("called" in line for line in lines), "the next branch is taken"
    monkeypatch.undo()
    assert replay(tmp_path / "record").identical, "a replay finds the same reading without an answer"
