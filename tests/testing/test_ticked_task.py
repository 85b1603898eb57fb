"""A task that a test ticks: one tick at a time, looked at from outside, and ended safely whatever the test does."""

import pytest

from stretch_bt import Status, run
from stretch_bt.errors import DeviceLost, InvalidInput, NotReady
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.units import Estimate

TREE = """\
format: stretch-tree/1
tick: 100 ms
devices: {arm: Arm}
keys: {height: {type: Length, default: 1 mm}}
trees:
  main:
    sequence:
      - wait: {duration: 0.5 s}
      - name: feel
        lower: {by: 1 mm}
      - set: {height: 2 mm}
      - {name: last, wait: {duration: 10 s}}
    finally: [retract: {clearance: 20 mm}]
"""
FELT = {"mocks": [{"match": "main/feel", "after": "0.3 s"}]}
RETRACT = "main/finally/retract"


@pytest.fixture
def arm(scripted_device):
    return scripted_device("Arm", motion=[MotionState.MOVING, MotionState.MOVING, MotionState.DONE])


def test_it_goes_on_by_one_tick(tick_task, arm):
    task = tick_task(TREE, mocks=FELT, devices={"arm": arm})
    assert (task.now, task.ticks, task.status("main/wait")) == (0.0, 0, Status.INVALID)
    assert [task.tick() for _ in range(3)] == [Status.RUNNING] * 3
    assert (task.now, task.ticks) == (pytest.approx(0.2), 3)
    assert task.status("main/wait") is Status.RUNNING
    assert task.keys["height"] == 1e-3


def test_until_goes_to_a_status_and_no_further(tick_task, arm):
    task = tick_task(TREE, mocks=FELT, devices={"arm": arm})
    task.until("main/feel")
    assert (task.now, task.status("main/wait")) == (pytest.approx(0.5), Status.SUCCESS)
    ticks = task.ticks
    task.until("main/feel", "running").until("main/wait", Status.SUCCESS)
    assert task.ticks == ticks
    assert task.until("main/last").keys["height"] == 2e-3


def test_the_end_is_that_of_a_run(tick_task, arm):
    task = tick_task(TREE, mocks=FELT, devices={"arm": arm})
    task.until("main/last")
    assert task.commands("arm") == []
    task.until("main/last", "SUCCESS", within=11)
    assert task.tick() is Status.SUCCESS
    assert task.outcome.status == "SUCCESS"
    assert [(c.name, c.owner) for c in task.commands("arm")] == [("move", RETRACT)]
    assert [task.status(path).name for path in ("main/last", RETRACT)] == ["SUCCESS", "SUCCESS"]
    ticks = task.ticks
    assert (task.tick(), task.ticks) == (Status.SUCCESS, ticks)


def test_what_mocks_expect_can_be_asked_for(tick_task, arm):
    mocks = {**FELT, "expect": {"result": "success", "visited": ["main/last#success"], "commands": ["arm.move"]}}
    task = tick_task(TREE, mocks=mocks, devices={"arm": arm}).until("main/last")
    assert "expected a visit of main/last#success" in task.unmet
    task.until("main/last", "SUCCESS").tick()
    assert task.unmet == []


@pytest.mark.parametrize("broken", [False, True], ids=["passed", "broken"])
def test_a_test_that_ends_early_leaves_nothing_moving(tick_task, arm, broken):
    task = tick_task(TREE.replace("- wait: {duration: 0.5 s}", "- retract: {clearance: 5 mm}"), devices={"arm": arm})
    if broken:
        with pytest.raises(AssertionError):
            task.until("main/last", within="0 s")
    task.tick()
    assert arm.moving is not None
    outcome = task.close()
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", "stopped by the end of the test")
    assert [c.owner for c in arm.commands if c.name == "move"] == ["main/retract", RETRACT]
    assert arm.moving is None
    assert task.status("main/retract") is Status.INVALID
    assert task.close() is outcome


def test_a_fault_ends_it_in_the_tick_that_meets_it(tick_task, scripted_device):
    arm = scripted_device("Arm", motion=[MotionState.MOVING, DeviceLost("arm", "the connection broke")])
    tree = TREE.replace("wait: {duration: 0.5 s}", "retract: {clearance: 5 mm}")
    task = tick_task(tree, mocks=FELT, devices={"arm": arm})
    assert task.tick() is Status.RUNNING
    assert task.tick() is Status.INVALID
    assert (task.outcome.status, task.reason) == ("FAULT", "main/retract: arm: the connection broke")


def test_a_device_in_fault_takes_no_command_any_more(tick_task, scripted_device):
    arm = scripted_device("Arm", {"force": ["1 N", "fault: the cable is out"]})
    tree = TREE.replace("wait: {duration: 0.5 s}", "{guard: arm.force < 2 N, wait: {duration: 1 s}}")
    task = tick_task(tree, mocks=FELT, devices={"arm": arm})
    assert task.tick() is Status.RUNNING
    assert task.tick() is Status.INVALID
    assert task.outcome.status == "FAULT"
    assert arm.commands == []
    with pytest.raises(NotReady, match="in fault until a new run: the cable is out"):
        arm.move(0.1, speed=0.01, owner="by hand")
    arm.open()
    arm.move(0.1, speed=0.01, owner="by hand")


def test_until_says_what_it_saw(tick_task, arm):
    task = tick_task(TREE, mocks=FELT, devices={"arm": arm})
    with pytest.raises(AssertionError, match=r"main/last did not come to RUNNING: 0.4 s are over") as caught:
        task.until("main/last", within="0.4 s")
    assert "it is INVALID" in str(caught.value)
    assert "RUNNING  main/wait" in str(caught.value)
    with pytest.raises(AssertionError, match="the task ended with SUCCESS"):
        task.until("main/wait", "FAILURE")


@pytest.mark.parametrize("path", ["main/wait", "main/fail", RETRACT])
def test_until_sees_what_the_last_tick_passes_through(tick_task, arm, path):
    tree = TREE[: TREE.index("    sequence")] + "    parallel: [wait: {duration: 1 s}, fail: no]\n"
    tree += "    finally: [retract: {clearance: 20 mm}]\n"
    status = "FAILURE" if path == "main/fail" else "RUNNING"
    task = tick_task(tree, devices={"arm": arm}).until(path, status)
    assert (task.outcome.status, task.ticks > 1) == ("FAILURE", True)
    with pytest.raises(AssertionError, match="the task ended with FAILURE"):
        task.until("main/wait", "SUCCESS")


#: wrong questions, and the messages
ASKED = {
    "path": (lambda task: task.until("main/fel"), "no node at 'main/fel'; did you mean 'main/feel'?"),
    "status": (lambda task: task.until("main/feel", "RUNING"), "'RUNING' is no status.*did you mean 'RUNNING'"),
    "device": (lambda task: task.commands("amr"), "no device 'amr'; did you mean 'arm'"),
    "unit": (lambda task: task.until("main/feel", within="60"), "60 has no unit; write '60 s'"),
}


@pytest.mark.parametrize("what", ASKED)
def test_a_wrong_question_names_the_right_one(tick_task, arm, what):
    ask, told = ASKED[what]
    with pytest.raises(InvalidInput, match=told):
        ask(tick_task(TREE, mocks=FELT, devices={"arm": arm}))


def test_devices_that_are_missing_are_named(tick_task):
    with pytest.raises(InvalidInput, match=r"needs arm; give it in 'devices', mock its nodes, or name a scene"):
        tick_task(TREE)
    with pytest.raises(InvalidInput, match=r"needs arm; give it in 'devices', or mock"):
        tick_task(TREE, devices={})


def test_without_devices_the_twin_of_the_tree_is_ticked(tick_task):
    tree = TREE.replace("trees:", "scene: calibration_sphere\ntrees:")
    task = tick_task(tree, mocks={"mocks": [{"match": "main/feel", "outputs": {}}]})
    task.until("main/last").close()
    assert [(c.device, c.name) for c in task.commands("arm")][:1] == [("arm", "move")]


NUMBER = """\
format: stretch-tree/1
keys: {k: Stiffness}
trees: {main: {sequence: [estimate_stiffness: {force: 1 N, deflection: 1 mm, stiffness: $k}, wait: {duration: 1 s}]}}
"""


def test_a_number_keeps_its_deviation(tick_task):
    given = {"value": "2 N/m", "sd": "0.5 N/m"}
    task = tick_task(NUMBER, mocks={"mocks": [{"match": "**/estimate_stiffness", "outputs": {"stiffness": given}}]})
    task.tick()
    assert task.keys["k"] == Estimate(2.0, 0.5)


@pytest.fixture
def left_safe():
    """Take the arms of a test, and look after its tasks were closed how they were left."""
    arms = []
    yield arms
    for arm in arms:
        assert arm.moving is None
        assert [command.owner for command in arm.commands if command.name == "move"] == ["main/retract", RETRACT]


@pytest.mark.parametrize(
    "fails", [False, pytest.param(True, marks=pytest.mark.xfail(raises=AssertionError, strict=True))]
)
def test_whatever_the_test_does_the_task_ends_safely_after_it(left_safe, tick_task, arm, fails):
    task = tick_task(TREE.replace("- wait: {duration: 0.5 s}", "- retract: {clearance: 5 mm}"), devices={"arm": arm})
    left_safe.append(arm)
    task.tick()
    assert arm.moving is not None
    assert not fails


BOARD = """\
format: stretch-tree/1
imports: {pb: py_trees.behaviours}
trees:
  main:
    sequence:
      - pb.SetBlackboardVariable: {variable_name: seen, variable_value: 3, overwrite: true}
      - pb.CheckBlackboardVariableExists: {variable_name: seen}
      - wait: {duration: 1 h}
"""


@pytest.mark.parametrize("end", ["close", "refused"])
def test_the_blackboard_is_as_before_once_the_task_has_ended(tick_task, end):
    from py_trees.blackboard import Blackboard

    Blackboard.set("of the caller", 1)
    before = dict(Blackboard.storage), dict(Blackboard.clients), set(Blackboard.metadata)
    try:
        if end == "close":
            task = tick_task(BOARD)
            task.until("main/wait", within="1 s")
            assert Blackboard.get("seen") == 3
            task.close()
        else:
            with pytest.raises(InvalidInput, match="the tree needs arm"):
                tick_task(
                    BOARD.replace("trees:", "devices: {arm: Arm}\ntrees:").replace("wait: {", "lower: {by: 1 mm} #")
                )
        assert (dict(Blackboard.storage), dict(Blackboard.clients), set(Blackboard.metadata)) == before
    finally:
        Blackboard.clear()


def test_a_device_of_another_kind_is_refused(tmp_path, scripted_device):
    """It was commanded as if it were an arm: `retract` moved the gripper, with SUCCESS."""
    path = tmp_path / "tree.yaml"
    path.write_text("format: stretch-tree/1\ndevices: {arm: Arm}\ntrees: {main: {retract: {clearance: 10 mm}}}\n")
    with pytest.raises(InvalidInput, match="'arm', a device of kind Arm, and was given one of kind Gripper; give each"):
        run(path, devices={"arm": scripted_device("Gripper")}, record="none")


def test_a_behaviour_that_counts_the_time_of_the_machine_gets_it(tick_task, tmp_path):
    path = tmp_path / "tree.yaml"
    path.write_text(
        "format: stretch-tree/1\nimports: {timer: py_trees.timers.Timer}\n"
        "trees: {main: {sequence: [timer: {duration: 0.3}, wait: {duration: 1 s}]}}\n"
    )
    tick_task(path).until("main/wait", within="3 s")
