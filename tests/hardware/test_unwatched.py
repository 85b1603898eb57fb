"""Motions that no tick looks at, because a node hangs: they end, and not at their target."""

import sys
import time

import pytest
from lab import lab_cell
from waiting import LIMIT, eventually

from stretch_bt import run
from stretch_bt.errors import DeviceFault, NotReady
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.tree import registry

LAB = {"arm": {"watchdog": "1 Hz", "lost_after": "1 s", "heartbeat": "5 s"}, "gripper": {}}
NODES = """
import time
from stretch_bt import Behavior, Status, node

@node
class Hang(Behavior):
    "Take long."

    def update(self):
        time.sleep(4.0)
        return Status.SUCCESS
"""
TREE = """\
format: stretch-tree/1
imports: {stuck: stuck_nodes}
devices: {arm: Arm, gripper: Gripper}
trees:
  main:
    parallel:
      - MOVING
      - sequence: [wait: {duration: 0.5 s}, stuck.hang: {}]
"""
#: what moves, where to, and where it must not have come: both are under way for 5 s
MOVES = {
    "arm": ("retract: {clearance: 100 mm, speed: 20 mm/s}", lambda behind: behind["ur"].state()["height"], (0.2, 0.26)),
    "gripper": (
        "set_stretch: {stretch: 75 mm, speed: 15 mm/s}",
        lambda behind: behind["robotiq"].state()["opening"],
        (0.05, 0.1),
    ),
}


@pytest.mark.parametrize("device", ["arm", pytest.param("gripper", marks=pytest.mark.slow)])
def test_a_node_that_hangs_has_what_moves_stopped(own_hosts, tmp_path, monkeypatch, device):
    step, place, (begin, most) = MOVES[device]
    monkeypatch.setattr(registry, "_nodes", registry.load_all())  # nodes registered here are forgotten after the test
    monkeypatch.delitem(sys.modules, "stuck_nodes", raising=False)
    (tmp_path / "stuck_nodes.py").write_text(NODES)
    (tmp_path / "tree.yaml").write_text(TREE.replace("MOVING", step))
    host = next(own_hosts)
    (tmp_path / "cell.yaml").write_text(lab_cell(host, LAB))
    with serving(["ur", "robotiq"], StandInWorld(), host=host, activated=True) as servers:
        result = run(tmp_path / "tree.yaml", cell=tmp_path / "cell.yaml", out=tmp_path / "record")
        rest = place(servers.stand_ins)
        time.sleep(0.2)
        assert place(servers.stand_ins) == pytest.approx(rest, abs=1e-6)
    assert result.status == "FAULT", result.reason
    assert f"{device}: no tick looked at the motion" in result.reason
    assert begin < rest < most


@pytest.mark.parametrize("kind", ["robotiq-rtu", pytest.param("urcap", marks=pytest.mark.slow)])
def test_fingers_that_nobody_looks_at_are_held(make_cell, clock, kind):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    motion = gripper.move(0.125, speed=0.05, owner="a")
    clock.time += 0.3
    eventually(lambda: not cell.stand_in.state()["moving"])
    with pytest.raises(DeviceFault, match="no tick looked at the motion"):
        motion.poll()
    assert gripper.state is DeviceState.FAULT
    assert cell.stand_in.state()["opening"] < 0.075
    gripper.close()
    gripper.open()
    assert gripper.opening(LIMIT).value < 0.075


def test_an_activation_into_which_a_refused_motion_came_is_held_too(make_cell, clock):
    cell = make_cell("robotiq-rtu")
    gripper = cell.devices["gripper"]
    motion = gripper.activate(owner="a")
    for _ in range(2):  # the reset, and the activation once that is shown
        clock.time += 0.1
        motion.poll()
    with pytest.raises(NotReady, match="being activated"):
        gripper.move(0.08, speed=0.05, owner="a")
    eventually(lambda: not cell.stand_in.state()["moving"])
    with pytest.raises(DeviceFault, match="no tick looked at the motion"):
        motion.poll()
