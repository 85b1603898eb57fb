"""Nodes of a reconstruction on scripted devices: where to press, how to get there, and how far to press."""

import numpy as np
import pytest

from stretch_bt.behaviors._views import counted, place_of
from stretch_bt.behaviors.records import PlannedView, Touch, TriedViews
from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.frames import DepthFrame, Intrinsics, Pose, Wrench
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.limits import Limits
from stretch_bt.perception.clouds.relief import Relief
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Status

TOUCHED = 0.060  # m
TOUCH = Touch(TOUCHED, 2e-5)
BLANK = DepthFrame(np.zeros((4, 4), np.uint16), 1e-3, Intrinsics(4.0, 4.0, 2.0, 2.0, 4, 4), 0.0, 0)


def known(size=40, border=10, top=0.06):
    """Return a map of a flat top, with nothing known around it."""
    felt = np.pad(np.ones((size, size)), border)
    start = -(size // 2) - border
    return Relief((start, start), np.where(felt > 0, top, np.inf), felt * top, felt, 0.0 * felt, views=1)


def test_poses_are_read_with_their_units():
    assert place_of("10 mm, -2cm") == pytest.approx((0.010, -0.020, 0.0))
    assert place_of("0 mm, 0 mm, 90 deg") == pytest.approx((0.0, 0.0, np.pi / 2))


@pytest.mark.parametrize(
    ("degrees", "same"), [(270, -90), (-190, 170), (360, 0), (540, 180), (180, 180), (-3700, -100)]
)
def test_a_turn_beyond_half_a_turn_is_the_same_one_within_it(degrees, same):
    *_, turn = place_of(f"0 mm, 0 mm, {degrees} deg")
    assert abs(turn) <= np.pi
    assert np.exp(1j * turn) == pytest.approx(np.exp(1j * np.radians(same)))


@pytest.mark.parametrize("text", ["10 mm", "1 mm, 2 mm, 3 deg, 4 mm", "10, 20", "10 mm, 20 deg", "10 mm, 0 mm, 5 mm"])
def test_a_pose_that_cannot_be_read_is_refused_before_the_run(bench, text):
    with pytest.raises(InvalidInput, match=r"poses|not a number"):
        bench().node("plan_view", poses=[text]).prepare()


def planned(bench, tried=None, **inputs):
    """Return where to press next, and what was tried after that."""
    node = bench.node("plan_view", **inputs)
    node.sinks["tried"].value = tried
    assert bench.tick(node) is Status.SUCCESS, node.reason
    return node.sinks["view"].value, node.sinks["tried"].value


def test_the_first_press_is_where_the_hand_is(bench):
    made = bench()
    made.stand(0.1, (0.0, 0.0, 0.3))
    view, _ = planned(made)
    assert view == PlannedView(0, 0, pytest.approx(0.3), request="", coverage=0, unseen=0, done=False)


def test_given_poses_are_taken_in_turn_and_no_more(bench):
    made = bench()
    poses = ["10 mm, 0 mm", "0 mm, 20 mm, 45 deg"]
    second, _ = planned(made, poses=poses, presses=1, relief=known())
    assert second.y == pytest.approx(0.020)
    assert "y 20 mm, turned by 45 deg" in second.request
    assert planned(made, poses=poses, presses=2, relief=known())[0].done
    assert planned(made, poses=poses, presses=1, max_presses=1, relief=known())[0].done


def test_planning_ends_with_the_bound_on_presses(bench):
    assert planned(bench(), relief=known(), presses=12)[0].done


def test_planning_ends_after_three_presses_that_showed_nothing_and_begins_anew_with_what_was_tried(bench):
    made, tried, ends = bench(), None, []
    for presses in (1, 2, 3, 4):
        view, tried = planned(made, tried, wanted_coverage=1.0, relief=known(), presses=presses)
        ends.append(view.done)
    assert ends == [False, False, False, True]
    assert (tried.count, len(set(tried.places))) == (3, 3), "no place twice"
    assert not planned(made, wanted_coverage=1.0, relief=known(), presses=5)[0].done


@pytest.mark.parametrize(
    ("presses", "areas", "fruitless"),
    [
        ((1, 2, 3, 4), [(1.0, 0.5)] * 4, 3),
        ((1, 1, 1, 1), [(1.0, 0.5)] * 4, 0),  # planned again without a press between
        (
            (1, 2, 3, 4),
            [(1.0, 0.5), (1.0, 0.5), (1.0, 0.3), (1.0, 0.3)],
            1,
        ),  # some of the unseen turned out not to be there
        ((1, 2), [(1.0, 0.5), (1.01, 0.495)], 1),
        ((1, 2), [(1.0, 0.5), (1.05, 0.48)], 0),
    ],
)
def test_presses_that_change_next_to_nothing_are_counted_in_a_row(presses, areas, fruitless):
    tried = TriedViews()
    for number, (seen, unseen) in zip(presses, areas, strict=True):
        tried = counted(tried, number, seen, unseen)
    assert tried.fruitless == fruitless
    assert tried.is_fruitless == (fruitless >= 3)


def test_the_hand_is_raised_before_it_goes_across(bench):
    made = bench()
    arm = made.context.devices["arm"] = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, 0.05), (0.0, 0.0, 0.1))})
    assert (
        made.run("move_over", touch=TOUCH, x=0.03, y=-0.01, yaw=np.pi - 0.1, clearance=0.015).status is Status.SUCCESS
    )
    up, across = arm.commands[0].arguments["path"]
    assert up.position == pytest.approx((0.0, 0.0, TOUCHED + 0.015))
    assert across.position == pytest.approx((0.03, -0.01, TOUCHED + 0.015))
    assert across.rotation[2] == pytest.approx(-0.1), "half a turn makes no other membrane"


@pytest.mark.parametrize("touch", [None, Touch(0.02, 2e-5)])
def test_above_all_that_was_felt_it_goes_across_where_it_stands(bench, touch):
    made = bench()
    arm = made.context.devices["arm"] = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, 0.05))})
    assert made.run("move_over", touch=touch, x=0.03, y=-0.01, clearance=0.015).status is Status.SUCCESS
    (across,) = arm.commands[0].arguments["path"]
    assert across.position == pytest.approx((0.03, -0.01, 0.05))


@pytest.mark.parametrize(("top", "raised"), [(0.055, TOUCHED), (0.07, 0.07)])
def test_first_contact_is_raised_to_the_highest_place_felt_and_never_lowered(bench, top, raised):
    node = bench().node("raise_touch", relief=known(top=top))
    node.sinks["touch"].value = TOUCH
    for _ in node.tick():
        pass
    assert node.status is Status.SUCCESS, node.reason
    assert node.sinks["touch"].value == Touch(pytest.approx(raised), TOUCH.height_sd)
    assert node.context.hand.contact_height == pytest.approx(raised), "the limits of the cell count from there, too"


def press(bench, script, motion=(MotionState.MOVING, MotionState.DONE), **inputs):
    """Press as the shipped subtree `press_gently` does; return the node, the arm and the depth reached."""
    arm = ScriptedDevice("Arm", script, list(motion))
    made = bench(camera=ScriptedDevice("DepthCamera", {"frame": BLANK}))
    made.context.devices["arm"] = arm
    node = made.run("press_watching", touch=TOUCH, depth=0.015, **inputs)
    if node.status is Status.SUCCESS and node.sinks["ended"].value == "balance":
        assert made.run("rise_to_balance", touch=TOUCH).status is Status.SUCCESS
    return node, arm, max(TOUCHED - arm.pose(0.0).value.height, 0.0)


def forces(*felt):
    return [Wrench((0.0, 0.0, f)) for f in felt]


def targets(arm):
    """Return where the arm was sent, m above first contact."""
    return [c.arguments["target"].height - TOUCHED for c in arm.commands if c.name == "move"]


@pytest.mark.parametrize(("felt", "ended"), [([0.1, 0.2], "depth"), ([0.1, 0.6], "force"), ([0.6], "force")])
def test_a_press_ends_at_its_depth_or_its_force(bench, felt, ended):
    script = {"pose": Pose((0.0, 0.0, TOUCHED - 0.004)), "wrench": forces(*felt)}
    node, arm, reached = press(bench, script, max_force=0.5)
    assert node.status is Status.SUCCESS
    assert node.sinks["ended"].value == ended
    assert reached == pytest.approx(0.004)
    assert targets(arm) == pytest.approx([-0.015])


def test_a_press_goes_no_lower_than_the_cell_lets_the_hand_go(bench):
    """It asked for a place below, which the cell refuses: a reconstruction ended at its first press."""
    made = bench(camera=ScriptedDevice("DepthCamera", {"frame": BLANK}))
    arm = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, TOUCHED - 0.004)), "wrench": forces(0.1)}, [MotionState.DONE])
    made.context.devices["arm"], made.context.limits = arm, Limits(height={"min": "50 mm", "max": "500 mm"})
    assert made.run("press_watching", touch=TOUCH, depth=0.015).status is Status.SUCCESS
    assert targets(arm) == pytest.approx([0.050 - TOUCHED])


def test_a_force_before_first_contact_means_that_something_is_in_the_way(bench):
    node, _, _ = press(bench, {"pose": Pose((0.0, 0.0, TOUCHED + 0.005)), "wrench": forces(9.0)})
    assert node.status is Status.FAILURE
    assert "5.0 mm above first contact" in node.reason


LOST, HELD = NoEquilibrium("the sheet slips off"), Wrench((0.0, 0.0, 0.1))


@pytest.mark.parametrize(
    ("readings", "heights", "reached", "sent"),
    [
        ([HELD, LOST, HELD], [-4, -4, -3], 0.003, [-15, -3]),
        ([LOST, LOST, HELD], [-4, -4, -3, -3, -2], 0.002, [-15, -3, -2]),
        ([LOST], [-1, -1, 2], 0.0, [-15, 2]),
    ],
)
def test_a_press_on_which_the_membrane_slips_goes_back_to_where_it_holds(bench, readings, heights, reached, sent):
    poses = [Pose((0.0, 0.0, TOUCHED + 1e-3 * z)) for z in [0.0, *heights]]
    node, arm, found = press(bench, {"pose": poses, "wrench": readings})
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "balance")
    assert found == pytest.approx(reached)
    assert targets(arm) == pytest.approx([1e-3 * z for z in sent])


def test_a_press_goes_back_too_where_the_arm_itself_finds_no_force(bench):
    poses = [Pose((0.0, 0.0, TOUCHED + 1e-3 * z)) for z in (0.0, -4, -4, -3)]
    states = [LOST, LOST, MotionState.MOVING, MotionState.DONE]
    node, arm, reached = press(bench, {"pose": poses, "wrench": HELD}, states)
    assert (node.status, node.sinks["ended"].value) == (Status.SUCCESS, "balance")
    assert reached == pytest.approx(0.003)
    assert targets(arm) == pytest.approx([-0.015, -0.003]), "on the way up it is not sent again"


def test_the_operator_is_asked(bench):
    operator = ScriptedDevice("Operator")
    assert bench(operator=operator).run("confirm", request="Now?").status is Status.SUCCESS
    (command,) = operator.commands
    assert (command.name, command.arguments) == ("confirm", {"request": "Now?"})
