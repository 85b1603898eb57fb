"""Tests of the task and of its node; none needs a robot, a scene, or an import from stretch_bt."""

import numpy as np
import pytest

TASK = "ripeness.yaml"


def looks(*more, second="3.8 mm"):
    """Return mocks of the camera and of both looks, after those that a test adds."""
    return {
        "mocks": [
            *more,
            {"match": "**/capture", "after": "0.1 s", "outputs": {"frame": {}}},
            {"match": "**/segment_contact", "outputs": {"contact": {}}},
            {"match": "main/shallow/crown_height", "outputs": {"crown": {"value": "3 mm", "sd": "0.03 mm"}}},
            {"match": "main/deep/crown_height", "outputs": {"crown": {"value": second, "sd": "0.04 mm"}}},
        ]
    }


@pytest.fixture
def arm(scripted_device):
    """An arm at 150 mm that feels 1 N, and whose motions take three ticks."""
    return scripted_device("Arm", {"height": "150 mm", "force": "1 N"}, motion=["moving", "moving", "done"])


@pytest.mark.parametrize(("second", "given_way", "ripe"), [("3.8 mm", 1.2, True), ("4.9 mm", 0.1, False)])
def test_fixed_values_lead_to_a_decision(run, arm, second, given_way, ripe):
    result = run(TASK, mocks=looks(second=second), devices={"arm": arm})
    assert result.status == "SUCCESS", result.reason
    assert result.outputs["given_way"]["value"] == pytest.approx(given_way)
    assert result.outputs["given_way"]["sd"] == pytest.approx(0.05)
    assert result.outputs["ripe"]["value"] is ripe


def test_a_camera_that_fails_at_the_second_look_ends_the_task(run, arm):
    fails = {"match": "main/deep/capture", "status": "failure", "message": "too dark"}
    result = run(TASK, mocks=looks(fails), devices={"arm": arm})
    assert (result.status, result.reason) == ("FAILURE", "main/deep/capture: too dark")


def test_a_camera_that_is_late_runs_into_the_timeout(run, arm):
    result = run(TASK, mocks=looks({"match": "main/shallow/capture", "after": "10 s"}), devices={"arm": arm})
    assert result.status == "FAILURE"
    assert "out of time while main/shallow/capture was running" in result.reason
    assert "main/deep" not in result.visited


def test_a_hard_fruit_takes_the_other_branch(run, arm):
    visited = run(TASK, mocks=looks(second="5 mm"), devices={"arm": arm}).visited
    assert visited["main/soft"] == ("FAILURE",)
    assert visited["main/hard"] == ("SUCCESS",)


def test_the_arm_goes_up_at_the_end(run, arm):
    expected = {"result": "success", "commands": ["arm.move", "arm.move", "arm.move"]}
    result = run(TASK, mocks={**looks(), "expect": expected}, devices={"arm": arm})
    assert result.unmet == []
    last = result.commands[-1]
    assert (last.name, last.owner) == ("move", "main/finally/retract")
    assert last.arguments["target"].height == pytest.approx(0.180)


def test_the_node_averages_the_top_of_an_array(tick_node):
    surface = np.zeros((20, 30, 3))
    surface[5, 5:11, 2] = 0.004
    surface[0] = np.nan
    result = tick_node("crown_height", contact={"surface": surface, "noise": "0.1 mm"})
    assert result.status == "SUCCESS", result.reason
    assert result.crown == pytest.approx(0.004)
    assert result.crown.sd == pytest.approx(0.1e-3 / 6**0.5)


def test_an_arm_that_is_lost_is_a_fault(run, scripted_device):
    arm = scripted_device("Arm", motion=["moving", "fault: the cable is out"])
    result = run(TASK, mocks=looks(), devices={"arm": arm})
    assert (result.status, result.reason) == ("FAULT", "main/shallow/lower: arm: the cable is out")


def test_tick_by_tick(tick_task, arm):
    task = tick_task(TASK, mocks=looks(), devices={"arm": arm})
    task.until("main/shallow/capture")
    assert [command.name for command in task.commands("arm")] == ["move"]
    task.until("main/deep/lower", within="2 s")
    assert task.keys["first"] == pytest.approx(0.003)
    assert "second" not in task.keys
    task.until("main/soft", "SUCCESS")
    assert task.status("main/hard").name == "INVALID"
