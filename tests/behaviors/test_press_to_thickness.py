"""Pressing to a thickness on scripted devices: what it ends by, and that no step goes past the limit of force unseen."""

import numpy as np
import pytest

from stretch_bt.behaviors.press_to_thickness import _lowest
from stretch_bt.behaviors.records import Touch
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.runtime.context import RunContext
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Status

TOUCHED, HAND, DISTANCE = 0.060, 0.055, 0.2  # of `bench`; of the hand while it presses
CAMERA = Intrinsics(476.0, 476.0, 106.0, 166.0, 213, 333)
MOVING, DONE, BLOCKED = MotionState.MOVING, MotionState.DONE, MotionState.BLOCKED
TOP = 0.008  # m over the flat membrane, at which the membrane over the flat top is seen
LIFT = 0.22e-3  # m, how far such a membrane stands above such a top


def frame(top):
    """Return what a camera sees of a membrane over a flat top of 15 mm radius with a slope around it."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    away = np.hypot(u - CAMERA.cx, v - CAMERA.cy) * DISTANCE / CAMERA.fx
    heights = np.clip(top - 0.4 * np.maximum(away - 0.015, 0.0), 0.0, None)
    return DepthFrame(np.round((DISTANCE - heights) / 1e-5).astype(np.uint16), 1e-5, CAMERA, 0.0, 0, DISTANCE)


@pytest.fixture
def press(bench):
    def made(forces, motion, top=TOP, limits=None, lean=0.0, **inputs):
        pose = Pose((0.0, 0.0, HAND), (lean, 0.0, 0.0))
        forces = [Wrench(tuple(f * pose.matrix()[:, 2])) for f in forces]
        arm = ScriptedDevice("Arm", {"pose": pose, "wrench": forces}, motion)
        run = bench(camera=ScriptedDevice("DepthCamera", {"frame": frame(top)}))
        run.context.devices["arm"], run.context.limits = arm, limits
        arm.now = lambda: run.context.now
        return run.run("press_to_thickness", touch=Touch(TOUCHED, 0.0), **inputs), arm

    return made


def test_a_top_that_is_low_enough_is_left_alone(press):
    node, arm = press([1.0], [DONE], thickness=HAND + TOP + 0.001)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "thickness")
    assert node.sinks["reached"].value == pytest.approx(HAND + TOP - LIFT, abs=1e-4)
    assert not arm.commands


@pytest.mark.parametrize("lean", [0.0, 0.3])
def test_the_force_is_that_along_the_hands_axis(press, lean):
    node, _ = press([2.0], [DONE], thickness=HAND + TOP + 0.005, lean=lean)
    assert (node.status, node.sinks["force"].value) == (Status.SUCCESS, pytest.approx(2.0))


def test_the_deviation_of_the_force_is_that_of_a_mean_of_its_readings(press):
    forces = np.random.default_rng(4).normal(2.0, 0.3, 11).tolist()
    node, _ = press(forces, [DONE], thickness=HAND + TOP + 0.005)
    force = node.sinks["force"]
    assert abs(force.value - 2.0) < 3 * force.sd
    assert force.sd == pytest.approx(0.3 / np.sqrt(10), rel=0.5)


@pytest.mark.parametrize("motion", [[DONE], [MOVING, DONE]])
def test_the_limit_of_force_ends_it_also_where_steps_are_shorter_than_a_tick(press, motion):
    node, arm = press([5.0], motion, thickness=0.055, max_force=4.0)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "force")
    assert [c.name for c in arm.commands] == (["move"] if motion == [DONE] else ["move", "stop"])
    target = arm.commands[0].arguments["target"]
    assert target.height == pytest.approx(0.055 - TOP + LIFT, abs=1e-4), "by what the top still has to fall"


def test_a_top_that_does_not_fall_is_given_up(press):
    node, arm = press([1.0], [DONE], thickness=0.055)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "depth")
    assert 1 < len(arm.commands) < 30


@pytest.mark.parametrize(
    ("limits", "lowest"),
    [
        pytest.param(None, 0.030, marks=pytest.mark.slow),
        (Limits(depth="12 mm"), 0.048),
        (Limits(depth="40 mm"), 0.030),
        (Limits(depth="40 mm", height={"min": "45 mm", "max": "500 mm"}), 0.045),
    ],
)
def test_no_step_goes_deeper_than_the_cell_allows(press, limits, lowest):
    node, arm = press([1.0], [DONE], limits=limits, thickness=0.020)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "depth")
    assert min(c.arguments["target"].height for c in arm.commands) == pytest.approx(lowest, abs=1e-9)


@pytest.mark.parametrize(("top", "motion", "why"), [(0.0, [DONE], "nothing stands"), (TOP, [BLOCKED], "blocked")])
def test_nothing_seen_and_a_blocked_hand_are_failures(press, top, motion, why):
    node, _ = press([1.0], motion, top, thickness=0.040)
    assert node.status is Status.FAILURE
    assert why in node.reason


def test_without_a_cell_no_step_goes_below_the_table():
    assert _lowest(0.010, 0.030, RunContext()) == 0.0
