"""Runs on devices that their caller gave: their readings are in the record, and tick the tree again."""

from pathlib import Path

import numpy as np
import pytest

import stretch_bt
from stretch_bt.clock import VirtualClock
from stretch_bt.errors import RecordError
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.perception import DepthFrame, Intrinsics
from stretch_bt.runtime.replay import replay
from stretch_bt.testing import ScriptedDevice

TREE = """\
format: stretch-tree/1
devices: {arm: Arm}
trees:
  main:
    guard: {that: arm.force < 2 N, name: gentle}
    sequence:
      - lower: {by: 1 mm}
      - wait: {duration: 200 ms}
      - lower: {by: 1 mm}
    finally: [retract: {clearance: 20 mm}]
"""
#: script, motion -> status of the run
SCRIPTS = {
    "guarded": ({"force": ["1 N", "1 N", "3 N"]}, ["moving", "done"], "FAILURE"),
    "done": ({"force": "1 N"}, ["moving", "moving", "done"], "SUCCESS"),
    "lost": ({"height": ["100 mm", "99 mm", "fault: cut"]}, ["moving", "done"], "FAULT"),
    "blocked": ({}, ["moving", "blocked"], "FAILURE"),
    "broke": ({}, ["moving", "fault: broke"], "FAULT"),
    "noisy": ({"force": ["1 N", "no answer: noisy"]}, ["done"], "FAILURE"),
}


@pytest.mark.parametrize("case", SCRIPTS)
def test_a_run_on_a_scripted_arm_is_ticked_again_from_its_record(run, scripted_device, case):
    script, motion, status = SCRIPTS[case]
    result = run(TREE, devices={"arm": scripted_device("Arm", script, motion=motion)})
    assert result.status == status
    assert result.readings["arm.wrench"]
    assert replay(result.record).identical


LOOK = """\
format: stretch-tree/1
devices: {eye: DepthCamera, fingers: Gripper}
trees:
  main:
    sequence:
      - capture: {frame, camera: eye}
      - set_stretch: {stretch: 1 mm, gripper: fingers}
      - check: fingers.opening > 0 mm
"""


def test_frames_and_openings_are_recorded_under_the_names_of_the_tree(run, scripted_device):
    frame = DepthFrame.from_array(np.full((8, 9), 0.1), Intrinsics(9.0, 9.0, 4.0, 4.0, 9, 8), unit=1e-4)
    eye, fingers = scripted_device("DepthCamera", {"frame": frame}), scripted_device("Gripper", motion=["done"])
    result = run(LOOK, devices={"eye": eye, "fingers": fingers})
    assert result.status == "SUCCESS", result.reason
    assert {"eye.frame", "fingers.opening"} <= result.readings.keys()
    assert replay(result.record).identical


def test_the_end_of_a_camera_is_recorded(scripted_device):
    heard = []

    class Journal:
        def reading(self, device, name, reading):
            heard.append((device, name, reading.value))

    going, ended = scripted_device("DepthCamera"), scripted_device("DepthCamera", ended=True)
    for name, camera in (("going", going), ("ended", ended)):
        camera.tell(name, Journal())
    assert (going.ended, ended.ended) == (False, True)
    assert heard == [("ended", "ended", True)]


TOUCH = """\
format: stretch-tree/1
devices: {left: Arm, fingers: Gripper, eye: DepthCamera}
trees:
  main:
    sequence:
      - set_stretch: {stretch: 10 mm, gripper: fingers}
      - raise: {by: 2 mm, arm: left}
"""


def test_devices_of_a_cell_are_recorded_as_the_tree_calls_them(run):
    tree = TOUCH.replace("raise: {by: 2 mm, arm: left}", "retract: {clearance: 2 mm, arm: left}")
    with stretch_bt.open_cell(scene="calibration_sphere") as cell:
        devices = {"left": cell.arm, "fingers": cell.gripper, "eye": cell.camera}
        result = run(tree, devices=devices)
    assert result.status == "SUCCESS", result.reason
    assert {command.device for command in result.commands} == {"left", "fingers"}
    assert replay(result.record).identical


class OwnArm:
    """A user's arm that reports its readings to nobody."""

    def __init__(self):
        self.clock = VirtualClock()

    def pose(self, max_age):
        return Reading(Pose((0.0, 0.0, 0.1)), self.clock.now(), self.clock.now(), 1)

    def stop(self):
        pass


def test_a_record_without_the_readings_of_a_device_says_so_and_is_not_replayed(run):
    tree = "format: stretch-tree/1\ndevices: {arm: Arm}\ntrees: {main: {sequence: [check: arm.height > 0 mm]}}\n"
    result = run(tree, devices={"arm": OwnArm()})
    assert result.status == "SUCCESS", result.reason
    with pytest.raises(RecordError, match=r"readings of arm.* are not in this record.*open it in a cell"):
        replay(result.record)
    assert Path(result.record, "run.json").exists()


def test_a_device_is_scripted_by_hand_as_before():
    device = ScriptedDevice("Arm", {"height": ["1 mm", "2 mm"]})
    assert [device.pose(1.0).value.height for _ in range(3)] == pytest.approx([0.001, 0.002, 0.002])
