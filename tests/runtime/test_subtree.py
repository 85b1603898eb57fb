"""Tasks inside somebody else's py_trees tree."""

import os
import random
import signal
from typing import ClassVar

import py_trees
import pytest
from py_trees.common import ParallelPolicy, Status

import stretch_bt
from stretch_bt.clock import VirtualClock
from stretch_bt.errors import CellError, DeviceFault, InvalidInput, StretchError
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior

HEAD = "format: stretch-tree/1\ndevices: {arm: Arm, gripper: Gripper}\ntrees:\n"
#: of {name}: takes a mark, moves a device for a while, and takes another mark at its end
MOVES = {
    "arm": "{retract: {clearance: 8 mm, speed: 20 mm/s}, name: NAME}",
    "gripper": "{set_stretch: {stretch: 3 mm, speed: 10 mm/s}, name: NAME}",
}


class MarkForTest(Behavior):
    """Count that it was ticked, by its path."""

    marks: ClassVar[list[str]] = []

    def update(self) -> Status:
        self.marks.append(self.path)
        return Status.SUCCESS


@pytest.fixture(autouse=True)
def _mark_node(monkeypatch):
    monkeypatch.setattr(registry, "_nodes", {**registry.load_all()})
    registry.node(MarkForTest)
    MarkForTest.marks.clear()


@pytest.fixture
def task(tmp_path):
    """Write a task, and return its path."""

    def write(body: str, name: str = "task", head: str = HEAD) -> str:
        path = tmp_path / f"{name}.yaml"
        path.write_text(head + body, encoding="utf-8")
        return str(path)

    return write


def moving(task, name: str, device: str, speed: str = "") -> str:
    """Return a task that marks its begin as `name`, moves a device, and marks in its finally."""
    move = MOVES[device].replace("NAME", name)
    begin, end = f"{{mark_for_test: {{}}, name: begin_{name}}}", f"{{mark_for_test: {{}}, name: end_{name}}}"
    return task(f"  main:\n    sequence: [{begin}, {move}]\n    finally: [{end}]\n", name)


def current(opened, device):
    motion = opened.devices[device]._current
    return motion if motion is not None and motion.refresh() is MotionState.MOVING else None


def ticked(behaviour, most: int = 4000) -> Status:
    for _ in range(most):
        behaviour.tick_once()
        if behaviour.status is not Status.RUNNING:
            return behaviour.status
    raise AssertionError("it does not end")


def test_a_subtree_gives_what_a_run_gives(opened, task):
    body = "  main:\n    out: {h0: Length}\n    sequence: [set_stretch: {stretch: 30 mm}, approach: {contact_height: $h0}]\n"
    path = task(body, head=HEAD.replace("gripper: Gripper", "gripper: Gripper, camera: DepthCamera"))
    tree = stretch_bt.subtree(path, opened)
    assert ticked(tree) is Status.SUCCESS, tree.feedback_message
    result = stretch_bt.run(path, scene="calibration_sphere")
    assert tree.outputs["h0"] * 1e3 == pytest.approx(result.outputs["h0"]["value"], rel=1e-9)
    assert tree.outputs["h0"].sd * 1e3 == pytest.approx(result.outputs["h0"]["sd"], rel=1e-6)


def test_a_command_names_the_subtree_that_gave_it(opened, task):
    path = task(
        "  main:\n    sequence: [retract: {clearance: 1 mm}]\n    finally: [retract: {clearance: 1 mm}]\n", "up"
    )
    first, second = (stretch_bt.subtree(path, opened) for _ in range(2))
    second.name = "second"
    assert [ticked(tree) for tree in (first, second)] == [Status.SUCCESS] * 2
    places = ("main/retract", "main/finally/retract")
    assert [c.owner for c in opened.commands] == [f"{name}/{place}" for name in ("up", "second") for place in places]


def test_it_begins_anew_each_time(opened, task):
    tree = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    assert [ticked(tree), ticked(tree)] == [Status.SUCCESS] * 2
    assert MarkForTest.marks == ["a/main/begin_a", "a/main/finally/end_a"] * 2


def test_an_interrupt_returns_at_once_and_the_finally_runs_before_anything_starts_again(opened, task):
    a, b = (stretch_bt.subtree(moving(task, n, d), opened) for n, d in (("a", "arm"), ("b", "gripper")))
    for _ in range(3):
        a.tick_once()
    assert current(opened, "arm") is not None
    a.stop(Status.INVALID)
    assert a.feedback_message == "interrupted in a/main/a"
    assert opened.pending_finally
    assert current(opened, "arm") is None
    assert MarkForTest.marks == ["a/main/begin_a"]
    b.tick_once()
    assert MarkForTest.marks == ["a/main/begin_a", "a/main/finally/end_a"]
    assert ticked(b) is Status.SUCCESS


def test_a_tree_that_is_attended_ticks_what_is_owed(opened, task):
    a = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    tree = py_trees.trees.BehaviourTree(py_trees.behaviours.Running("r"))
    opened.attend(tree)
    a.tick_once()
    a.stop(Status.INVALID)
    tree.tick()
    assert MarkForTest.marks[-1] == "a/main/finally/end_a"


@pytest.mark.parametrize("leave", ["close", "do", "run"])
def test_what_is_owed_runs_before_whatever_comes_next_on_the_cell(opened, task, leave):
    a = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    a.tick_once()
    a.stop(Status.INVALID)
    {
        "close": opened.close,
        "do": lambda: opened.do("wait", duration=0.1),
        "run": lambda: stretch_bt.run(moving(task, "b", "gripper"), cell=opened),
    }[leave]()
    assert MarkForTest.marks[1] == "a/main/finally/end_a"


def test_a_call_on_the_cell_waits_for_a_finally_that_goes_on(opened, task):
    """It took the arm from it: the hand was left down, and the finally was said not to have ended in time."""
    path = task("  main:\n    sequence: [check: 1 > 2]\n    finally: [retract: {clearance: 30 mm, speed: 10 mm/s}]\n")
    opened.do("lower", by="5 mm", speed="20 mm/s")
    before = opened.arm.pose(1.0).value.height
    subtree = stretch_bt.subtree(path, opened)
    for _ in range(5):
        subtree.tick_once()
    assert subtree.status is Status.RUNNING
    opened.do("lower", by="1 mm", speed="20 mm/s")
    assert opened.arm.pose(1.0).value.height > before + 10e-3
    assert subtree.status is Status.INVALID


def test_a_finally_that_moves_goes_on_over_ticks_and_no_interrupt_cuts_it_short(opened, task):
    end = "{retract: {clearance: 5 mm, speed: 20 mm/s}}, {mark_for_test: {}}"
    a = stretch_bt.subtree(
        task(f"  main:\n    sequence: [{MOVES['gripper'].replace('NAME', 'x')}]\n    finally: [{end}]\n"), opened
    )
    a.tick_once()
    a.stop(Status.INVALID)
    a.stop(Status.INVALID)
    before = opened.arm.pose(1.0).value.height
    a.tick_once()  # which waits
    assert a.status is Status.RUNNING
    a.stop(Status.INVALID)
    opened.close()
    assert MarkForTest.marks == ["task/main/finally/mark_for_test"]
    assert before == pytest.approx(0.12)


def test_two_of_them_in_parallel_go_at_the_speed_of_one(opened, task):
    both = [stretch_bt.subtree(moving(task, n, d), opened) for n, d in (("a", "arm"), ("b", "gripper"))]
    tree = py_trees.composites.Parallel("p", ParallelPolicy.SuccessOnAll(), children=both)
    for _ in range(9):
        tree.tick_once()
    assert opened.clock.now() == pytest.approx(8 * 0.05)


def test_an_interrupt_leaves_the_motion_of_another_one_alone(opened, task):
    a, b = (stretch_bt.subtree(moving(task, n, d), opened) for n, d in (("a", "arm"), ("b", "gripper")))
    guard = py_trees.decorators.EternalGuard("g", a, condition=lambda: opened.clock.now() < 0.1, blackboard_keys=[])
    children = [py_trees.decorators.FailureIsSuccess("f", guard), b]
    tree = py_trees.composites.Parallel("p", ParallelPolicy.SuccessOnAll(), children=children)
    for _ in range(6):
        tree.tick_once()
    assert a.status is Status.INVALID
    assert current(opened, "arm") is None
    assert current(opened, "gripper") is not None
    assert ticked(tree) is Status.SUCCESS
    assert MarkForTest.marks.count("b/main/begin_b") == 1


def test_a_pause_that_is_too_long_is_an_error_after_a_safe_stop(opened, task):
    a = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    a.tick_once()
    a.tick_once()
    opened.clock.advance(0.19)
    a.tick_once()
    assert current(opened, "arm") is not None
    opened.clock.advance(0.21)
    with pytest.raises(StretchError, match=r"0\.21 s lie between two ticks, and it may be 0\.2 s; tick the tree every"):
        a.tick_once()
    assert current(opened, "arm") is None
    opened.close()
    assert MarkForTest.marks[-1] == "a/main/finally/end_a"


def test_a_behaviour_of_py_trees_inside_lets_the_clock_go_no_faster_than_the_machine(opened, task):
    head = HEAD.replace("devices:", "imports: {timer: py_trees.timers.Timer}\ndevices:")
    path = task("  main:\n    sequence: [{timer: {duration: 0.3}, timeout: 3 s}]\n", head=head)
    tree = stretch_bt.subtree(path, opened)
    assert ticked(tree) is Status.SUCCESS, tree.feedback_message
    assert 0.25 <= opened.clock.now() <= 1.0


def test_a_fault_stops_the_cell_and_is_raised_from_the_tick(opened, task, monkeypatch):
    both = [stretch_bt.subtree(moving(task, n, d), opened) for n, d in (("a", "arm"), ("b", "gripper"))]
    tree = py_trees.composites.Parallel("p", ParallelPolicy.SuccessOnAll(), children=both)
    tree.tick_once()
    tree.tick_once()
    fault = DeviceFault("arm", "protective stop")
    monkeypatch.setattr(opened.arm._current, "_poll", lambda: (_ for _ in ()).throw(fault))
    with pytest.raises(DeviceFault, match="protective stop"):
        tree.tick_once()
    assert current(opened, "gripper") is None


def test_what_breaks_in_an_interrupt_is_raised_at_the_next_tick(opened, task, monkeypatch):
    a = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    a.tick_once()
    a.tick_once()
    monkeypatch.setattr(opened.arm.driver, "stop", lambda: (_ for _ in ()).throw(DeviceFault("arm", "no brake")))
    a.stop(Status.INVALID)
    monkeypatch.undo()
    with pytest.raises(DeviceFault, match="no brake"):
        a.tick_once()
    opened.close()


def test_a_cell_that_closes_amid_a_subtree_runs_its_finally(opened, task):
    a = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    for _ in range(3):
        a.tick_once()
    opened.close()
    assert MarkForTest.marks == ["a/main/begin_a", "a/main/finally/end_a"]
    assert a.status is Status.INVALID


def test_two_that_owe_are_done_one_after_the_other(opened, task):
    back = "{set_stretch: {stretch: STRETCH, speed: 10 mm/s}}"
    both = [
        stretch_bt.subtree(
            task(
                f"  main:\n    sequence: [wait: {{duration: 9 s}}]\n    finally: [{back.replace('STRETCH', way)}]\n",
                way[0],
            ),
            opened,
        )
        for way in ("5 mm", "2 mm")
    ]
    for tree in both:
        tree.tick_once()
    for tree in both:
        tree.stop(Status.INVALID)
    opened.do("wait", duration=0.01)
    assert opened.gripper.opening(1.0).value == pytest.approx(0.057)


def test_a_fault_in_what_is_owed_stops_the_cell_and_is_raised_by_the_tree_that_is_attended(opened, task, monkeypatch):
    a = stretch_bt.subtree(task("  main:\n    sequence: [wait: {duration: 9 s}]\n    finally: [retract: {}]\n"), opened)
    tree = py_trees.trees.BehaviourTree(py_trees.behaviours.Running("r"))
    opened.attend(tree)
    a.tick_once()
    a.stop(Status.INVALID)
    motion = opened.gripper.move(0.08, speed=0.001, owner="by hand")
    monkeypatch.setattr(opened.arm.driver, "pose", lambda: (_ for _ in ()).throw(DeviceFault("arm", "cut off")))
    with pytest.raises(DeviceFault, match="cut off"):
        tree.tick()
    assert motion.poll() is MotionState.STOPPED


def test_the_clock_goes_on_where_a_subtree_ends_in_its_first_tick(opened, task):
    a = stretch_bt.subtree(task("  main: {sequence: [check: arm.height > 1 m]}\n"), opened)
    for _ in range(20):
        a.tick_once()
        assert a.status is Status.FAILURE
    assert opened.clock.now() == pytest.approx(0.95)


@pytest.mark.parametrize("slow_first", [True, False])
def test_subtrees_of_different_ticks_go_together(opened, task, slow_first):
    slow = stretch_bt.subtree(
        task("  main: {sequence: [wait: {duration: 2 s}]}\n", "slow", HEAD.replace("trees:", "tick: 500 ms\ntrees:")),
        opened,
    )
    fast = stretch_bt.subtree(moving(task, "a", "arm"), opened)
    children = [slow, fast] if slow_first else [fast, slow]
    tree = py_trees.composites.Parallel("p", ParallelPolicy.SuccessOnAll(), children=children)
    assert ticked(tree) is Status.SUCCESS


def test_the_params_that_a_scene_asks_for_are_taken(tmp_path):
    path = tmp_path / "t.yaml"
    body = "params: {max_force: {default: 5 N}}\ntrees: {main: {out: [f], sequence: [set: {f: max_force}]}}\n"
    path.write_text(f"format: stretch-tree/1\n{body}", encoding="utf-8")
    with stretch_bt.open_cell(scene="paper_cube") as paper:
        tree = stretch_bt.subtree(path, paper)
        assert ticked(tree) is Status.SUCCESS
        assert tree.outputs["f"] < 5.0


def test_a_tree_of_other_devices_and_a_library_are_refused_before_anything_moves(opened, task):
    with pytest.raises(CellError, match="left"):
        stretch_bt.subtree(task("  main: {retract: {arm: left}}\n", head=HEAD.replace("arm:", "left:")), opened)
    with pytest.raises(InvalidInput, match="library for import"):
        stretch_bt.subtree(task("  other: {in: [speed], sequence: [retract: {speed}]}\n"), opened)
    assert opened.commands == []


DECORATORS = {
    "inverter": lambda child, _: py_trees.decorators.Inverter("i", child),
    "failure": lambda child, _: py_trees.decorators.FailureIsSuccess("f", child),
    "running": lambda child, _: py_trees.decorators.SuccessIsRunning("s", child),
    "repeat": lambda child, r: py_trees.decorators.Repeat("r", child, r.choice([1, 2, -1])),
    "retry": lambda child, r: py_trees.decorators.Retry("t", child, r.choice([1, 2])),
    "one_shot": lambda child, _: py_trees.decorators.OneShot("o", child, py_trees.common.OneShotPolicy.ON_COMPLETION),
    "guard": lambda child, r: py_trees.decorators.EternalGuard(
        "g", child=child, condition=lambda: r.random() > 0.1, blackboard_keys=[]
    ),
    "timeout": lambda child, _: py_trees.decorators.Timeout("d", child, duration=1e3),
}


class Composer:
    """Draws trees of py_trees around subtrees of ours."""

    def __init__(self, opened, paths, generator):
        self.cell, self.paths, self.random = opened, dict(paths), generator
        self.subtrees = {}

    def tree(self, depth: int = 3):
        kind = self.random.choice(["leaf", "decorator", "composite", "composite"]) if depth else "leaf"
        if kind == "decorator":
            return DECORATORS[self.random.choice(sorted(DECORATORS))](self.tree(depth - 1), self.random)
        if kind == "composite":
            return self.composite([self.tree(depth - 1) for _ in range(self.random.randint(1, 3))])
        return self.leaf()

    def composite(self, children):
        memory = self.random.random() < 0.5
        policy = self.random.choice([ParallelPolicy.SuccessOnOne(), ParallelPolicy.SuccessOnAll(synchronise=False)])
        return self.random.choice(
            [
                lambda: py_trees.composites.Sequence("seq", memory, children),
                lambda: py_trees.composites.Selector("sel", memory, children),
                lambda: py_trees.composites.Parallel("par", policy, children),
            ]
        )()

    def leaf(self):
        if self.paths and self.random.random() < 0.6:
            name, path = self.paths.popitem()
            self.subtrees[name] = made = stretch_bt.subtree(path, self.cell)
            return made
        key = py_trees.behaviours.SetBlackboardVariable("w", "left_behind", 1, overwrite=True)
        return self.random.choice(
            [
                py_trees.behaviours.Success("s"),
                py_trees.behaviours.Failure("f"),
                py_trees.behaviours.TickCounter("c", self.random.randint(0, 4), Status.SUCCESS),
                py_trees.timers.Timer("t", 1e3),
                key,
            ]
        )


@pytest.mark.parametrize("seed", [pytest.param(s, marks=pytest.mark.slow if s > 3 else ()) for s in range(40)])
def test_whatever_is_around_it_no_motion_outlives_its_interrupt_and_no_other_is_stopped(task, seed):
    generator = random.Random(seed)
    names = {f"{device[0]}{k}": device for k in range(2) for device in MOVES}
    paths = {name: moving(task, name, device) for name, device in names.items()}
    with stretch_bt.open_cell(scene="calibration_sphere") as opened:
        for _ in range(25):
            composer = Composer(opened, paths, generator)
            root = composer.tree()
            tree = py_trees.trees.BehaviourTree(root)
            if generator.random() < 0.5:
                opened.attend(tree)
            for _ in range(generator.randint(1, 25)):
                running = {n for n, s in composer.subtrees.items() if s.status is Status.RUNNING}
                seen, before = len(opened.commands), motions(opened)
                tree.tick()
                check(opened, composer, running, opened.commands[seen:], before)
            running = {n for n, s in composer.subtrees.items() if s.status is Status.RUNNING}
            seen, before = len(opened.commands), motions(opened)
            tree.interrupt()
            root.stop(Status.INVALID)
            check(opened, composer, running, opened.commands[seen:], before)
            assert not any(current(opened, device) for device in MOVES)
            opened.settle()
            begun = [mark for mark in MarkForTest.marks if "/begin_" in mark]
            ended = [mark for mark in MarkForTest.marks if "/end_" in mark]
            assert sorted(m.rpartition("_")[2] for m in begun) == sorted(m.rpartition("_")[2] for m in ended)
            py_trees.blackboard.Blackboard.clear()


def motions(opened):
    return [motion for device in MOVES if (motion := current(opened, device)) is not None]


def check(opened, composer, running, commands, before):
    """After a tick or an interrupt: only what runs moves, and only what stopped was stopped."""
    now = {name for name, tree in composer.subtrees.items() if tree.status is Status.RUNNING}
    for device in MOVES:
        motion = current(opened, device)
        if motion is not None:
            assert motion.owner.partition("/")[0] in now
    for motion in before:
        if motion.owner.partition("/")[0] in now:
            assert motion.refresh() is not MotionState.STOPPED
    stopped = {command.owner.partition("/")[0] for command in commands if command.name == "stop"}
    assert stopped <= running | {c.owner.partition("/")[0] for c in commands if c.name != "stop"}
    restarted = {mark.rpartition("_")[2] for mark in MarkForTest.marks}
    assert stopped <= restarted


def test_the_clock_of_a_simulated_cell_is_virtual(opened):
    assert isinstance(opened.clock, VirtualClock)


def test_what_breaks_in_a_safe_stop_is_raised_later(opened, task, monkeypatch):
    a = stretch_bt.subtree(moving(task, "a", "gripper"), opened)
    a.tick_once()
    a.tick_once()
    monkeypatch.setattr(opened.arm.driver, "stop", lambda: (_ for _ in ()).throw(DeviceFault("arm", "no brake")))
    opened.clock.advance(0.4)
    with pytest.raises(StretchError, match="s lie between two ticks"):
        a.tick_once()
    monkeypatch.undo()
    with pytest.raises(DeviceFault, match="no brake"):
        a.tick_once()


def test_a_signal_while_a_cell_closes_ends_what_is_owed(opened, task, monkeypatch):
    """None was heard until it had all been done, which took a minute at most for each."""
    end = "{wait: {duration: 50 s}}, {mark_for_test: {}}"
    a = stretch_bt.subtree(
        task(f"  main:\n    sequence: [{MOVES['gripper'].replace('NAME', 'x')}]\n    finally: [{end}]\n"), opened
    )
    a.tick_once()
    advance = opened.clock.advance

    def struck(seconds: float) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        advance(seconds)

    monkeypatch.setattr(opened.clock, "advance", struck)
    began = opened.clock.now()
    with pytest.raises(KeyboardInterrupt) as stopped:
        opened.close()
    assert any("task/main/finally: cut short by SIGINT" in note for note in stopped.value.__notes__)
    assert opened.clock.now() - began < 1.0
    assert MarkForTest.marks == []


def test_a_signal_while_a_cell_closes_is_heard_by_what_comes_after(opened, monkeypatch):
    stop = opened.arm.driver.stop

    def struck() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        stop()

    opened.arm.move(opened.arm.pose(1.0).value, speed=0.01, owner="by hand")
    monkeypatch.setattr(opened.arm.driver, "stop", struck)
    with pytest.raises(KeyboardInterrupt):
        opened.close()
    opened.close()


def test_the_time_of_a_task_counts_from_its_begin_also_where_it_waited_for_what_was_owed(opened, task):
    opened.clock.advance(5.0)
    end = "  main:\n    sequence: [wait: {duration: 9 s}]\n    finally: [wait: {duration: 0.3 s}]\n"
    a = stretch_bt.subtree(task(end, "a"), opened)
    b = stretch_bt.subtree(task("  main: {sequence: [check: task.time < 0.2 s]}\n", "b"), opened)
    a.tick_once()
    a.stop(Status.INVALID)
    assert ticked(b) is Status.SUCCESS, b.feedback_message
