"""The fixtures that the package gives to tests."""

import math
import re

import pytest

from stretch_bt.errors import DeviceLost, InvalidInput, NoAnswer
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import INTERFACES, MotionState
from stretch_bt.testing import ScriptedDevice

TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
scene: water_balloon
params: {time: {type: Time, default: 1 s}}
trees:
  main:
    guard: arm.force < 2 N
    sequence:
      - wait: {duration: $time}
"""


def test_virtual_clock_moves_only_when_told(virtual_clock):
    assert virtual_clock.now() == 0.0
    virtual_clock.advance(1.5)
    virtual_clock.wait_until(1.0)
    assert virtual_clock.now() == 1.5


def test_cell_opens_on_the_clock_and_closes(cell, virtual_clock):
    opened = cell(scene="calibration_sphere", seed=3)
    motion = opened.devices["arm"].move(Pose((0, 0, 0.1)), speed=0.05, owner="test")
    assert motion.poll() is MotionState.MOVING
    virtual_clock.advance(1.0)
    assert motion.poll() is MotionState.DONE


def test_run_takes_text_and_mocks(run):
    assert run(TREE, params={"time": 0.2}).status == "SUCCESS"
    mocks = "format: stretch-mocks/1\ntree: tree2.yaml\nmocks:\n  - {match: main/wait, status: failure}\nreadings: {arm.force: 1 N}\n"
    assert run(TREE, mocks=mocks).reason == "main/wait: mocked failure"
    mocks = "format: stretch-mocks/1\ntree: tree3.yaml\nreadings: {arm.force: [1 N, 3 N]}\n"
    assert "does not hold: arm.force = 3 N" in run(TREE, mocks=mocks).reason


@pytest.mark.parametrize("kind", INTERFACES)
def test_scripted_device_is_its_interface(scripted_device, kind):
    assert isinstance(scripted_device(kind), INTERFACES[kind]) or kind == "DepthCamera"


def test_scripted_device_says_what_it_is_told(scripted_device, virtual_clock):
    arm = scripted_device("Arm", {"pose": [Pose((0, 0, 1.0)), Pose((0, 0, 2.0))], "wrench": DeviceLost("arm", "gone")})
    virtual_clock.advance(2.0)
    assert [arm.pose(1).value.height for _ in range(3)] == [1.0, 2.0, 2.0]
    assert arm.pose(1).host_time == 2.0
    with pytest.raises(DeviceLost):
        arm.wrench(1)


def test_scripted_motion_has_an_owner():
    arm = ScriptedDevice("Arm", motion=[MotionState.MOVING, MotionState.DONE])
    first = arm.move(Pose(), speed=0.1, owner="a")
    second = arm.move(Pose(), speed=0.1, owner="b")
    first.stop()
    assert first.poll() is MotionState.PREEMPTED
    assert [second.poll(), second.poll(), second.poll()] == [MotionState.MOVING, MotionState.DONE, MotionState.DONE]
    second.stop()
    third = arm.move(Pose(), speed=0.1, owner="c")
    third.stop()
    assert third.poll() is MotionState.STOPPED
    assert [c.name + c.owner for c in arm.commands] == ["movea", "moveb", "movec", "stopc"], (
        "what has ended is not stopped"
    )


def test_scripted_device_of_no_kind():
    with pytest.raises(InvalidInput, match="Arm"):
        ScriptedDevice("Arms")


def test_run_takes_scripted_devices(run, scripted_device):
    arm = scripted_device("Arm", {"wrench": [Wrench((0.0, 0.0, 1.0))] * 3 + [Wrench((0.0, 0.0, 3.0))]})
    result = run(TREE, devices={"arm": arm})
    assert (result.status, result.ticks) == ("FAILURE", 4)
    assert "arm.force = 3 N" in result.reason


def test_a_scripted_device_refuses_the_owners_that_a_real_one_refuses():
    arm = ScriptedDevice("Arm")
    with pytest.raises(InvalidInput, match="Arm: a motion's owner is the path of the node"):
        arm.move(Pose(), speed=0.1, owner=None)
    assert arm.commands == []


#: a script in words, its device, the reading that is asked, and what it gives
WORDS = {
    "force": ({"force": ["1 N", 3.0]}, "Arm", "wrench", [Wrench((0.0, 0.0, 1.0)), Wrench((0.0, 0.0, 3.0))]),
    "height": ({"height": "20 mm"}, "Arm", "pose", [Pose((0.0, 0.0, 0.02))]),
    "opening": ({"opening": [0.06, "55 mm"]}, "Gripper", "opening", [0.06, 0.055]),
}


@pytest.mark.parametrize("name", WORDS)
def test_a_script_is_written_in_words(name):
    script, kind, reading, values = WORDS[name]
    device = ScriptedDevice(kind, script)
    assert [getattr(device, reading)(1).value for _ in values] == values


def test_faults_and_motions_have_words():
    arm = ScriptedDevice(
        "Arm", {"force": ["1 N", "fault: the cable is out", "no answer: too noisy"]}, motion=["moving", "blocked"]
    )
    motion = arm.move(Pose(), speed=0.1, owner="test")
    assert [motion.poll() for _ in range(3)] == [MotionState.MOVING, MotionState.BLOCKED, MotionState.BLOCKED]
    arm.wrench(1)
    with pytest.raises(DeviceLost, match="arm: the cable is out"):
        arm.wrench(1)
    with pytest.raises(NoAnswer, match="too noisy"):
        arm.wrench(1)
    noisy = ScriptedDevice("Arm", {"force_noise": [0.02, "0.01 N", "no answer: too noisy", "fault: the cable is out"]})
    assert [noisy.force_noise() for _ in range(2)] == [0.02, 0.01]
    for error, said in ((NoAnswer, "too noisy"), (DeviceLost, "arm: the cable is out")):
        with pytest.raises(error, match=said):
            noisy.force_noise()
    lost = ScriptedDevice("Gripper", motion=["fault: jammed"]).move(0.06, speed=0.1, owner="test")
    with pytest.raises(DeviceLost, match="gripper: jammed"):
        lost.poll()


#: scripts that are wrong, and what is said
WRONG = {
    "name": ({"froce": 1.0}, {}, "has no 'froce'; did you mean 'force'"),
    "unit": ({"force": "1 mm"}, {}, "force: 1 mm is Length, not Force"),
    "empty": ({"force": []}, {}, "gives no value of 'force'"),
    "state": ({}, {"motion": ["moving", "blockd"]}, "no state 'blockd'; did you mean 'blocked'"),
    "no state": ({}, {"motion": []}, "has at least one state"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_script_says_what_to_write(what):
    script, options, told = WRONG[what]
    with pytest.raises(InvalidInput, match=told):
        ScriptedDevice("Arm", script, **options)


def test_files_beside_the_test_are_found(tmp_path, monkeypatch):
    from stretch_bt.testing.plugin import _Trees

    (tmp_path / "task.yaml").write_text(TREE, encoding="utf-8")
    trees = _Trees(tmp_path / "other", tmp_path)
    assert trees.placed("task.yaml") == (tmp_path / "task.yaml", None)
    assert trees.placed("palpate_stiffness") == ("palpate_stiffness", None)
    assert trees.beside({"mocks": []}) == {"mocks": []}
    monkeypatch.chdir(tmp_path)
    assert trees.beside("task.yaml") == "task.yaml"


@pytest.mark.parametrize(
    ("script", "told"),
    [
        ({"height": math.nan}, "height: no device gives nan; write a number that one can give, or 'no answer: why'"),
        ({"wrench": [1.0, math.inf]}, "wrench: no device gives inf"),
        ({"force_noise": None}, "force_noise: no device gives None; write a number that one can give"),
        ({"wrench": [1.0], "force": 5.0}, "gives its wrench twice, by 'force' too; leave out one"),
    ],
)
def test_a_script_that_no_device_could_follow_is_refused(scripted_device, script, told):
    with pytest.raises(InvalidInput, match=re.escape(told)):
        scripted_device("Arm", script)


@pytest.mark.parametrize(
    ("kind", "name", "told"),
    [
        ("Arm", "opening", "it has force, force_noise, height, pose, wrench"),
        ("Arm", "heigth", "did you mean 'height'? it has force,"),
        ("Gripper", "force", "it has opening"),
        ("Operator", "frame", "leave it out, it gives no reading"),
    ],
)
def test_a_reading_that_such_a_device_has_not_is_refused(scripted_device, kind, name, told):
    with pytest.raises(InvalidInput, match=re.escape(f"the script of a {kind} has no {name!r}; {told}")):
        scripted_device(kind, {name: "1 mm"})
