"""Nodes of a reconstruction on scripted devices: where to press, how to get there, and how far to press."""

import numpy as np
import pytest

from stretch_bt.behaviors.plan_view import pose_of
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Status

TOUCHED = 0.060  # of `bench`
BLANK = DepthFrame(np.zeros((4, 4), np.uint16), 1e-3, Intrinsics(4.0, 4.0, 2.0, 2.0, 4, 4), 0.0, 0)


def known(size=40, border=10, top=0.06):
    """Return a map of a flat top, with nothing known around it."""
    felt = np.pad(np.ones((size, size)), border)
    start = -(size // 2) - border
    return Relief((start, start), np.where(felt > 0, top, np.inf), felt * top, felt, 0.0 * felt, views=1)


def test_poses_are_read_with_their_units():
    assert pose_of("10 mm, -2cm") == pytest.approx((0.010, -0.020, 0.0))
    assert pose_of("0 mm, 0 mm, 90 deg") == pytest.approx((0.0, 0.0, np.pi / 2))


@pytest.mark.parametrize("text", ["10 mm", "1 mm, 2 mm, 3 deg, 4 mm", "10, 20", "10 mm, 20 deg", "10 mm, 0 mm, 5 mm"])
def test_a_pose_that_cannot_be_read_is_refused_before_the_run(bench, text):
    with pytest.raises(InvalidInput, match=r"poses|not a number"):
        bench().node("plan_view", poses=[text]).prepare()


def test_the_first_press_is_where_the_hand_is(bench):
    made = bench()
    made.stand(0.1, (0.0, 0.0, 0.3))
    node = made.run("plan_view")
    told = {name: node.sinks[name].value for name in ("done", "x", "y", "yaw", "request", "coverage")}
    assert told == {"done": False, "x": 0, "y": 0, "yaw": pytest.approx(0.3), "request": "", "coverage": 0}


def test_given_poses_are_taken_in_turn_and_no_more(bench):
    made = bench()
    poses = ["10 mm, 0 mm", "0 mm, 20 mm, 45 deg"]
    second = made.run("plan_view", poses=poses, presses=1, relief=known())
    assert second.sinks["y"].value == pytest.approx(0.020)
    assert "y 20 mm, turned by 45 deg" in second.sinks["request"].value
    assert made.run("plan_view", poses=poses, presses=2, relief=known()).sinks["done"].value
    assert made.run("plan_view", poses=poses, presses=1, max_presses=1, relief=known()).sinks["done"].value


def test_planning_ends_with_the_bound_on_presses_and_after_three_that_showed_nothing(bench):
    made = bench()
    assert made.run("plan_view", relief=known(), presses=12).sinks["done"].value
    node = made.node("plan_view", wanted=1.0, relief=known())
    ends = []
    for presses in (1, 2, 3, 4):
        node.wiring["presses"] = lambda presses=presses: presses
        made.tick(node)
        ends.append(node.sinks["done"].value)
    assert ends == [False, False, False, True]


def test_the_hand_is_raised_before_it_goes_across(bench):
    made = bench()
    arm = made.context.devices["arm"] = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, 0.05), (0.0, 0.0, 0.1))})
    assert made.run("move_over", x=0.03, y=-0.01, yaw=np.pi - 0.1, clearance=0.015).status is Status.SUCCESS
    up, across = arm.commands[0].arguments["path"]
    assert up.position == pytest.approx((0.0, 0.0, TOUCHED + 0.015))
    assert across.position == pytest.approx((0.03, -0.01, TOUCHED + 0.015))
    assert across.rotation[2] == pytest.approx(-0.1), "half a turn makes no other membrane"


def press(bench, force, at, **inputs):
    camera = ScriptedDevice("DepthCamera", {"frame": BLANK})
    motion = [MotionState.MOVING, MotionState.DONE]
    arm = ScriptedDevice(
        "Arm", {"pose": Pose((0.0, 0.0, at)), "wrench": [Wrench((0.0, 0.0, f)) for f in force]}, motion
    )
    made = bench(camera=camera)
    made.context.devices["arm"] = arm
    return made.run("press_gently", depth=0.015, **inputs), arm


@pytest.mark.parametrize(("force", "ended"), [([0.1, 0.2], "depth"), ([0.1, 0.6], "force"), ([0.6], "force")])
def test_a_press_ends_at_its_depth_or_its_force(bench, force, ended):
    node, arm = press(bench, force, TOUCHED - 0.004, max_force=0.5)
    assert node.status is Status.SUCCESS
    assert node.sinks["ended"].value == ended
    assert node.sinks["reached"].value == pytest.approx(0.004)
    assert arm.commands[0].arguments["target"].height == pytest.approx(TOUCHED - 0.015)


def test_a_force_before_first_contact_means_that_something_is_in_the_way(bench):
    node, _ = press(bench, [9.0], TOUCHED + 0.005)
    assert node.status is Status.FAILURE
    assert "5.0 mm above first contact" in node.reason


LOST, HELD = NoEquilibrium("the sheet slips off"), Wrench((0.0, 0.0, 0.1))


@pytest.mark.parametrize(
    ("readings", "heights", "reached", "targets"),
    [
        ([HELD, LOST, HELD], [-4, -4, -3, -3], 0.003, [-15, -3]),
        ([LOST, LOST, HELD], [-4, -4, -3, -3, -3, -2, -2], 0.002, [-15, -3, -2]),
        ([LOST], [-1, -1, 2, 2, 2], 0.0, [-15, 2]),
    ],
)
def test_a_press_on_which_the_membrane_slips_goes_back_to_where_it_holds(bench, readings, heights, reached, targets):
    poses = [Pose((0.0, 0.0, TOUCHED + 1e-3 * z)) for z in [0.0, *heights]]
    arm = ScriptedDevice("Arm", {"pose": poses, "wrench": readings})
    made = bench(camera=ScriptedDevice("DepthCamera", {"frame": BLANK}))
    made.context.devices["arm"] = arm
    node = made.run("press_gently", depth=0.015)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "balance")
    assert node.sinks["reached"].value == pytest.approx(reached)
    moves = [c.arguments["target"].height - TOUCHED for c in arm.commands if c.name == "move"]
    assert moves == pytest.approx([1e-3 * z for z in targets])


def test_a_press_goes_back_too_where_the_arm_itself_finds_no_force(bench):
    poses = [Pose((0.0, 0.0, TOUCHED + 1e-3 * z)) for z in (0.0, -4, -4, -3, -3, -3)]
    states = [LOST, LOST, MotionState.MOVING, MotionState.DONE]
    arm = ScriptedDevice("Arm", {"pose": poses, "wrench": HELD}, states)
    made = bench(camera=ScriptedDevice("DepthCamera", {"frame": BLANK}))
    made.context.devices["arm"] = arm
    node = made.run("press_gently", depth=0.015)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "balance")
    assert node.sinks["reached"].value == pytest.approx(0.003)
    assert [c.name for c in arm.commands].count("move") == 2, "on the way up it is not sent again"


def test_the_operator_is_asked(bench):
    operator = ScriptedDevice("Operator")
    assert bench(operator=operator).run("confirm", request="Now?").status is Status.SUCCESS
    (command,) = operator.commands
    assert (command.name, command.arguments) == ("confirm", {"request": "Now?"})
