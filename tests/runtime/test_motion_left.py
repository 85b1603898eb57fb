"""A node that ends or is interrupted leaves no motion under way, whatever class it has; a replay says the same."""

import sys
from pathlib import Path

import pytest

from stretch_bt.runtime.replay import replay

MODULE = '''
from stretch_bt import Behavior, Status, Uses, node
from stretch_bt.hardware.interfaces import Arm

@node
class Lowers(Behavior):
    """Commands a motion, and leaves it to itself after some ticks."""
    arm: Uses[Arm]

    def initialise(self):
        target = self.arm.pose(0.2).value.moved(z=-0.08)
        self.motion, self.ticks = self.arm.move(target, speed=0.01, owner=self.path), 0

    def update(self):
        self.motion.poll()
        self.ticks += 1
        return Status.RUNNING if self.ticks < 5 else Status.{end}
'''
TREE = """
format: stretch-tree/1
imports: {{own: {module}}}
devices: {{arm: Arm}}
scene: water_balloon
trees:
  main:
    out: [early, late]
    sequence:
      - {body}
      - set: {{early: arm.height}}
      - wait: {{duration: 2 s}}
      - set: {{late: arm.height}}
"""
BODIES = {
    "it succeeds": ("SUCCESS", "lowers"),
    "it fails": ("FAILURE", "force_success: [lowers]"),
    "a timeout interrupts it": ("RUNNING", "force_success: {timeout: {after: 0.5 s, do: [lowers]}}"),
    "a guard interrupts it": ("RUNNING", "{force_success: [{guard: arm.height > 116 mm, sequence: [lowers]}]}"),
}


@pytest.mark.parametrize("case", BODIES)
def test_a_motion_ends_with_its_node(run, tmp_path, monkeypatch, own_nodes, case):
    end, body = BODIES[case]
    name = f"left_{'_'.join(case.split())}"
    (tmp_path / f"{name}.py").write_text(MODULE.format(end=end))
    path = tmp_path / "tree.yaml"
    path.write_text(TREE.format(module=name, body=body))
    result = run(path, modules=tmp_path)
    assert result.status == "SUCCESS", result.reason
    heights = [result.outputs[key]["value"] for key in ("early", "late")]
    assert heights[0] - heights[1] < 1.0  # mm; it went down by 20 mm meanwhile
    assert [c.name for c in result.commands if c.owner.endswith("lowers")] == ["move", "stop"]
    sys.modules.pop(name, None)
    assert replay(Path(result.record), trust=True).identical
