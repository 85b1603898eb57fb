"""One test for each place where py_trees surprises (G1 to G23): what it does there, and what ours does."""

import os
import signal
import threading
import time
import typing
from collections.abc import Callable
from itertools import pairwise
from typing import Any, ClassVar, Literal

import numpy as np
import py_trees
import pytest

from stretch_bt.behaviors._motion import MotionBehavior
from stretch_bt.clock import RealClock, VirtualClock
from stretch_bt.errors import DeviceLost, InvalidInput, NodeError
from stretch_bt.hardware.interfaces import Arm, DeviceState, Motion, MotionState
from stretch_bt.hardware.simulated.camera import SimulatedCamera
from stretch_bt.runtime.context import RunContext
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Out, Status, Uses
from stretch_bt.units import Length

pytestmark = [pytest.mark.filterwarnings("error"), pytest.mark.hard]


class MoveTo(MotionBehavior):
    """Move the hand to a height."""

    instant: ClassVar[bool] = True  # not true, so that two of them fit into one reactive node
    arm: Uses[Arm]
    height: In[Length]

    def __init__(self, path: str = "") -> None:
        super().__init__(path)
        self.instant = False  # type: ignore[misc]

    def start(self) -> Motion:
        """Move straight up or down."""
        return self.arm.move(self.arm.pose(1.0).value.at_height(self.height), speed=0.1, owner=self.path)


def test_G1_preemption_starts_the_new_action_first_and_the_old_one_does_not_stop_it(
    bench: Any, cell: Callable[..., Any], virtual_clock: VirtualClock
) -> None:
    """py_trees: a naive `terminate(): arm.stop()` of the old action stops the new one's motion; here a motion has an owner."""
    registry.node(MoveTo)
    context, devices = RunContext(), cell()
    context.devices = devices.devices
    outcome = bench.run(
        """
        reactive_selector:
          - sequence:
              - check: {that: task.ticks > 3}
              - name: high
                move_to: {height: 300 mm}
          - name: low
            move_to: {height: 100 mm}
        """,
        "devices: {arm: Arm}",
        context=context,
        clock=virtual_clock,
        cell=devices,
    )
    arm = devices.devices["arm"]
    changes = [(path.rpartition("/")[2], status) for _, path, status, _ in bench.events.statuses]
    assert changes.index(("high", "RUNNING")) < changes.index(("low", "INVALID")), "new first, as py_trees has it"
    assert outcome.status == "SUCCESS"
    assert arm.pose(1.0).value.height == pytest.approx(0.300)


def test_G1_two_long_actions_in_one_reactive_node_are_refused_at_load(bench: Any) -> None:
    """py_trees: lets them pre-empt each other; here the tree does not load."""
    assert bench.codes("reactive_selector: [{name: a, probe: {}}, {name: b, probe: {}}]") == {"reactive-action"}


def test_G2_an_interrupt_leaves_nothing_running(bench: Any) -> None:
    """py_trees: `interrupt()` leaves nodes RUNNING without `terminate`; here each ends, by one `terminate`."""
    runner = bench.runner("parallel: [{name: a, probe: {script: R}}, {name: b, probe: {script: RRi}}]")
    outcome = runner.run()
    assert (outcome.status, outcome.ticks) == ("INTERRUPTED", 3)
    assert {node.status for node in runner.tree.nodes.values()} == {Status.INVALID}
    assert [bench.trace.count(f"{n}.term(I)") for n in "ab"] == [1, 1]


@pytest.mark.parametrize(("letter", "name"), [("i", "SIGINT"), ("t", "SIGTERM")])
def test_G3_a_signal_during_update_stops_safely(bench: Any, letter: str, name: str) -> None:
    """py_trees: KeyboardInterrupt leaves `tick()` with no `terminate`, SIGTERM is not handled; here both stop safely."""
    devices = bench.Devices()
    outcome = bench.run(
        f"""
        name: a
        probe: {{script: RR{letter}R}}
        finally: [{{name: end, probe: {{}}}}]
        """,
        cell=devices,
    )
    assert (outcome.status, outcome.reason, outcome.ticks) == ("INTERRUPTED", f"stopped by {name}", 4)
    assert bench.trace[-4:] == ["a.term(I)", "end.init", "end.tick", "end.term(S)"]
    assert devices.stops == 2, "before `finally`, and after it"


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_G3_a_signal_during_the_wait_ends_it_at_once(bench: Any, name: str) -> None:
    """py_trees: Ctrl-C during the sleep is swallowed; here it ends the wait, and the task."""
    runner = bench.runner("name: a\nprobe: {script: R}", clock=RealClock(), period=60.0, max_ticks=2)
    waiting = threading.Event()
    runner.clock.wait_until = _then(waiting.set, runner.clock.wait_until)
    sender = threading.Thread(target=lambda: (waiting.wait(), os.kill(os.getpid(), getattr(signal, name))))
    sender.start()
    outcome = runner.run()
    sender.join()
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", f"stopped by {name}")
    assert outcome.ticks < 2
    assert runner.clock.now() < 60.0
    assert bench.trace.count("a.term(I)") == outcome.ticks


def _then(first: Callable[[], Any], second: Callable[..., Any]) -> Callable[..., Any]:
    def both(*arguments: Any) -> Any:
        first()
        return second(*arguments)

    return both


def test_G4_an_error_in_update_ends_the_task_and_is_never_resumed(bench: Any) -> None:
    """py_trees: the next tick resumes the faulty child without `initialise`; here the task ends, and siblings are terminated."""
    outcome = bench.run("parallel: [{name: a, probe: {script: R}}, {name: b, probe: {script: RX}}]")
    assert (outcome.status, outcome.ticks) == ("ERROR", 2)
    assert outcome.reason == "main/b: RuntimeError: broken"
    assert [bench.trace.count(entry) for entry in ("b.tick", "a.term(I)", "b.term(I)")] == [2, 1, 1]


def test_G4_a_node_that_breaks_in_its_first_tick_is_told_too(bench: Any) -> None:
    """py_trees: it never was RUNNING, so nobody stops what it began; here it started, so it is terminated."""
    outcome = bench.run("sequence: [{name: a, probe: {}}, {name: b, probe: {script: X}}]")
    assert outcome.reason == "main/b: RuntimeError: broken"
    assert bench.trace[-1] == "b.term(I)"
    assert bench.trace.count("a.term(S)") == 1
    assert "a.term(I)" not in bench.trace


def test_G5_an_error_in_terminate_does_not_keep_the_others_running(bench: Any) -> None:
    """py_trees: the first raise ends the stop walk and all three stay RUNNING; here each is terminated, errors are collected."""
    outcome = bench.run(
        "parallel: [{name: a, probe: {script: R}}, {name: b, probe: {script: R, stop_script: X}}, {name: c, probe: {script: Ri}}]"
    )
    assert outcome.status == "INTERRUPTED"
    assert [entry for entry in bench.trace if "term" in entry] == ["c.term(I)", "b.term(I)", "a.term(I)"]
    assert outcome.errors == ["main/b: terminate() broke (RuntimeError: broken)"]


def test_G6_the_last_started_is_stopped_first(bench: Any) -> None:
    """py_trees: first child first, in stopping as in setting up; here last in, first out."""
    children = ", ".join(f"{{name: {n}, probe: {{script: R}}}}" for n in "abc")
    bench.run(f"parallel: [{children}]", max_ticks=1)
    assert bench.trace[-3:] == ["c.term(I)", "b.term(I)", "a.term(I)"]


def test_G6_a_device_that_does_not_open_closes_those_before_it(
    cell: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """py_trees: a failed setup leaves `up, new, new`; here the cell is closed again."""
    opened: list[Any] = []
    from stretch_bt.hardware.monitored.base import Monitored

    monkeypatch.setattr(Monitored, "open", _noting(opened, Monitored.open))
    monkeypatch.setattr(SimulatedCamera, "open", _lost)
    with pytest.raises(DeviceLost):
        cell()
    assert [device.name for device in opened] == ["arm", "gripper", "camera"]
    assert {device.state for device in opened} == {DeviceState.DISCONNECTED}


def _noting(found: list[Any], method: Callable[..., None]) -> Callable[..., None]:
    def noted(self: Any) -> None:
        found.append(self)
        method(self)

    return noted


def _lost(self: Any) -> None:
    raise DeviceLost("camera", "no such camera")


def test_G7_terminate_comes_once_for_each_start(bench: Any) -> None:
    """py_trees: it comes again when the parent restarts, and to children that never ran; here starts and ends match."""
    outcome = bench.run(
        """
        repeat:
          times: 3
          do:
            sequence:
              - name: a
                probe: {script: RS}
              - invert: {name: b, probe: {script: RF}}
              - selector: [{name: c, probe: {}}, {name: never, probe: {}}]
        """
    )
    assert outcome.status == "SUCCESS"
    for name, ends in (("a", "S"), ("b", "F"), ("c", "S")):
        mine = [e.removeprefix(f"{name}.") for e in bench.trace if e.startswith(f"{name}.") and "tick" not in e]
        assert mine == ["init", f"term({ends})"] * 3
    assert not any(e.startswith("never") for e in bench.trace)


def test_G8_a_halt_is_instantaneous_and_the_next_owner_begins_where_it_brakes(
    cell: Callable[..., Any], virtual_clock: VirtualClock
) -> None:
    """py_trees: a node cannot take its time to stop; here the device brakes by itself and takes the next command."""
    arm = cell().devices["arm"]
    top = arm.pose(1.0).value
    first = arm.move(top.moved(z=-0.1), speed=0.1, owner="one")
    virtual_clock.advance(0.5)
    first.stop()
    at = arm.pose(1.0).value.height
    assert first.poll() is MotionState.STOPPED
    virtual_clock.advance(1.0)
    rest = arm.pose(1.0).value.height
    assert at - rest == pytest.approx(0.1**2 / (2 * 0.5), abs=1e-9), "v^2 / 2a"
    second = arm.move(top, speed=0.1, owner="two")
    virtual_clock.advance(5.0)
    assert (second.poll(), arm.pose(1.0).value.height) == (MotionState.DONE, pytest.approx(top.height))


def test_G9_completed_actions_stay_done_while_the_guard_is_asked_on_every_tick(bench: Any) -> None:
    """py_trees: memory never re-checks guards, no memory re-runs actions; here `guard` is asked and `sequence` remembers."""
    outcome = bench.run(
        """
        guard: {that: task.ticks < 4, name: early}
        sequence: [{name: moved, probe: {}}, {name: acting, probe: {script: R}}]
        """
    )
    assert (outcome.status, outcome.ticks) == ("FAILURE", 4)
    assert "early" in outcome.reason
    assert "task.ticks = 4" in outcome.reason
    assert bench.trace.count("moved.init") == 1
    assert bench.trace[-1] == "acting.term(I)"


def test_G9_a_condition_that_runs_does_not_kill_the_action_behind_it(bench: Any) -> None:
    """py_trees: a guard that returns RUNNING kills the action; here a condition is an expression, true or false."""
    assert bench.codes("{guard: {that: task.ticks}, name: a, probe: {}}") == {"type-mismatch"}


def test_G10_parallel_runs_a_finished_child_once_and_ends_with_the_first_failure(bench: Any) -> None:
    """py_trees: without synchronise a finished child starts again and [S,R]/[R,S] never ends; here it waits, done."""
    outcome = bench.run("parallel: [{name: a, probe: {script: S}}, {name: b, probe: {script: RS}}]")
    assert (outcome.status, outcome.ticks, bench.trace.count("a.init")) == ("SUCCESS", 2, 1)
    outcome = bench.run(
        """
        parallel:
          policy: success_on_one
          children: [{name: x, probe: {script: S}}, {name: y, probe: {script: F}}, {name: z, probe: {script: R}}]
        """
    )
    assert outcome.status == "FAILURE", "any failure fails it"
    assert not [entry for entry in bench.trace if entry.startswith("z.")], (
        "never started: its motion would be one too many"
    )


def test_G11_a_timeout_goes_by_the_clock_of_the_run_and_a_late_success_is_none(bench: Any) -> None:
    """py_trees: `Timeout` reads time.monotonic() and calls a late SUCCESS a success; here neither."""
    before = time.monotonic()
    outcome = bench.run("name: a\ntimeout: 150 ms\nprobe: {script: RRRRS}")
    assert (outcome.status, outcome.ticks, outcome.task_seconds) == ("FAILURE", 4, pytest.approx(0.15))
    assert "out of time" in outcome.reason
    assert bench.trace[-1] == "a.term(I)"
    outcome = bench.run("name: b\ntimeout: 3600 s\nprobe: {script: RS}", period=1800.0)
    assert outcome.status == "SUCCESS"
    assert time.monotonic() - before < 1800, "no wall time passes"


def test_G12_attempts_count_all_and_loops_without_a_pass_are_refused(bench: Any) -> None:
    """py_trees: `Repeat(0)` never ends; here a loop has at least one pass, and attempts are attempts in all."""
    outcome = bench.run("name: a\nretry: 3\nprobe: {script: F}")
    assert (outcome.status, bench.trace.count("a.init")) == ("FAILURE", 3)
    assert bench.codes("repeat: {times: 0, do: {name: a, probe: {}}}") == {"out-of-bounds"}


def test_G12_a_tree_is_run_once(bench: Any) -> None:
    """py_trees: a reused OneShot silently does nothing; here there is none, and a used tree is refused."""
    assert bench.codes("name: a\none_shot: {probe: {}}")
    tree = bench.build("name: a\nprobe: {}")
    assert bench.run(tree).status == "SUCCESS"
    with pytest.raises(InvalidInput, match="build a new tree"):
        bench.run(tree)


class GiveItems(Behavior):
    """Write a list in which an item counts as false."""

    instant: ClassVar[bool] = True
    items: Out[list[int]]

    def update(self) -> Status:
        """Write it."""
        self.items = [1, 0, 3]
        return Status.SUCCESS


def test_G13_an_empty_list_ticks_nothing_and_a_zero_does_not_end_a_loop(bench: Any) -> None:
    """py_trees: `ForEach` ticks the child once for an empty list and stops at an item that counts as false; here neither."""
    registry.node(GiveItems)
    head = "keys: {n: int, items: 'list[int]'}\nparams: {empty: {type: 'list[int]', default: []}}"
    loop = "for_each: {{items: {}, as: $n, do: {{name: a, probe: {{}}}}}}"
    assert bench.run(loop.format("$empty"), head).status == "SUCCESS"
    assert bench.trace == []
    outcome = bench.run(f"sequence: [give_items: {{items: $items}}, {loop.format('$items')}]", head)
    assert (outcome.status, bench.trace.count("a.init")) == ("SUCCESS", 3)


@pytest.mark.parametrize("letter", ["N", "I"])
def test_G14_update_without_a_status_is_an_error_that_names_the_node(bench: Any, letter: str) -> None:
    """py_trees: None becomes INVALID with a printed line, and the Sequence neither fails nor succeeds; here it is an error."""
    outcome = bench.run(f"sequence: [{{name: a, probe: {{script: {letter}}}}}, {{name: b, probe: {{}}}}]")
    assert outcome.status == "ERROR"
    assert outcome.reason.startswith("main/a: update() returned")
    assert bench.trace[-1] == "a.term(I)"


@pytest.mark.parametrize("body", ["sequence: []", "selector: []", "parallel: []", "parallel: {children: []}"])
def test_G14_a_composite_without_children_is_refused_at_load(bench: Any, body: str) -> None:
    """py_trees: an empty Sequence succeeds, an empty Selector fails; here neither loads."""
    assert bench.codes(body)


def test_G15_an_anchor_gives_two_nodes_and_equal_names_get_numbers(bench: Any) -> None:
    """py_trees: one object may end up under two parents; here each place has a node, and a path, of its own."""
    tree = bench.build("sequence: [&again {probe: {script: RS}}, *again]")
    nodes = [node for path, node in tree.nodes.items() if "probe" in path]
    assert [node.path for node in nodes] == ["main/probe[0]", "main/probe[1]"]
    assert nodes[0] is not nodes[1]
    assert bench.run(tree).ticks == 3
    for node in tree.nodes.values():
        assert [child.parent for child in node.children] == [node] * len(node.children)


@pytest.mark.parametrize(("depth", "codes"), [(100, set()), (101, {"depth"}), (400, {"yaml-depth"})])
def test_G16_depth_is_bounded_at_load(bench: Any, depth: int, codes: set[str]) -> None:
    """py_trees: a chain of 994 ticks, one of 1000 is a RecursionError in the middle of a task; here 100 is the limit."""
    body = "{invert: " * (depth - 1) + "{name: a, probe: {}}" + "}" * (depth - 1)
    assert bench.codes(body) == codes
    if not codes:
        assert bench.run(body).ticks == 1


def test_G17_values_stay_in_their_tree_and_the_blackboard_stays_empty(bench: Any) -> None:
    """py_trees: storage, metadata and clients are class attributes, so values leak; here a key is a cell of its tree."""
    body = "{{sequence: [set: {{n: {}}}, probe: {{script: RS}}], out: {{n: int}}}}"
    trees = [bench.build(body.format(n)) for n in (1, 2)]
    runners = [bench.runner(tree) for tree in trees]
    for runner in runners:
        list(runner.tree.root.tick())
    assert [tree.outputs["n"][1].value for tree in trees] == [1, 2]
    board = py_trees.blackboard.Blackboard
    assert (board.storage, board.metadata, board.clients) == ({}, {}, {})


def test_G18_only_one_thread_ticks(bench: Any) -> None:
    """py_trees: two threads run `update` at the same time; here the second is refused."""
    runner = bench.runner("probe: {script: RRRRRRRRS}")
    results: list[Any] = []

    def run() -> None:
        try:
            results.append(runner.run().status)
        except RuntimeError as error:
            results.append(str(error))

    threads = [threading.Thread(target=run) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(results)[0] == "SUCCESS"
    assert [r for r in results if r != "SUCCESS"] == ["a runner runs its tree once; build a new tree for a new run"] * 3
    assert bench.trace.count("probe.tick") == 9


def test_G18_a_key_with_a_dot_is_refused_and_an_input_is_read_only(bench: Any) -> None:
    """py_trees: `a.b` registers and cannot be written; here it is no name for a key, and inputs cannot be assigned."""
    assert bench.codes("probe: {}", "keys: {a.b: int}")
    node = next(iter(bench.build("probe: {}").nodes.values()))
    with pytest.raises(NodeError, match="cannot be written"):
        node.script = "S"


class Takes(Behavior):
    """Take one of each kind of port."""

    instant: ClassVar[bool] = True
    seen: ClassVar[dict[str, Any]] = {}
    number: In[float] = 0.0
    count: In[int] = 0
    many: In[list[float]] = []  # noqa: RUF012
    mode: In[Literal["a", "b"]] = "a"
    length: In[Length | None] = None

    def update(self) -> Status:
        """Remember them."""
        self.seen.update({name: getattr(self, name) for name in self.ports})
        return Status.SUCCESS


class GiveFloat32(Behavior):
    """Write a number as numpy has it."""

    instant: ClassVar[bool] = True
    number: Out[float]

    def update(self) -> Status:
        """Write it."""
        self.number = np.float32(0.5)  # type: ignore[assignment]
        return Status.SUCCESS


@pytest.mark.parametrize(
    ("port", "text", "value"),
    [
        ("number", "10", 10.0),
        ("number", "2e-3", 0.002),
        ("many", "[1, 2.5]", [1.0, 2.5]),
        ("mode", "b", "b"),
        ("length", "10 mm", pytest.approx(0.010)),
        ("count", "yes", None),
        ("count", "true", None),
        ("count", "1.5", None),
        ("mode", "c", None),
        ("length", "10", None),
        ("number", "ten", None),
    ],
)
def test_G19_literals_are_typed_at_load(bench: Any, port: str, text: str, value: Any) -> None:
    """py_trees: raw isinstance, so 10 in a float port is a TypeError at tick; here 10 is 10.0, and a wrong type is a load error."""
    registry.node(Takes)
    body = f"takes: {{{port}: {text}}}"
    if value is None:
        assert bench.codes(body)
        return
    assert bench.run(body).status == "SUCCESS"
    assert Takes.seen[port] == value
    assert type(Takes.seen["number"]) is float


def test_G19_a_numpy_number_goes_through_a_port(bench: Any) -> None:
    """py_trees: np.float32 into a float port is a TypeError; here types are checked where they are known, at load."""
    registry.node(Takes)
    registry.node(GiveFloat32)
    outcome = bench.run("sequence: [give_float32: {number: $x}, takes: {number: $x}]", "keys: {x: float}")
    assert (outcome.status, Takes.seen["number"]) == ("SUCCESS", 0.5)


@pytest.mark.parametrize("annotation", [dict[str, float], Callable[[], None], typing.Any])
def test_G19_a_port_that_the_language_cannot_type_is_refused_when_its_node_is_registered(
    own_nodes: None, annotation: Any
) -> None:
    """py_trees: NotImplementedError or TypeError at some tick; here at the decorator, with the port's name."""
    cls = type("Odd", (Behavior,), {"__doc__": "Odd.", "__annotations__": {"odd": In[annotation]}})
    with pytest.raises(registry.RegistryError, match="port 'odd'"):
        registry.node(cls)


class Needs(Behavior):
    """Need a number."""

    number: In[float]


@pytest.mark.parametrize(
    ("body", "head", "code"),
    [
        ("needs: {}", "", "port-missing"),
        ("needs: {number: $name}", "keys: {name: {type: str, default: x}}", "type-mismatch"),
        ("needs: {number: $x}", "keys: {x: float}", "read-before-write"),
    ],
)
def test_G20_wiring_is_checked_at_load(bench: Any, body: str, head: str, code: str) -> None:
    """py_trees: `setup()` is content, the first read fails; here the tree does not load."""
    registry.node(Needs)
    assert bench.codes(body, head) == {code}


def test_G20_a_name_that_is_taken_is_refused(own_nodes: None) -> None:
    """py_trees: the registry is global and the last one wins with a warning; here the second is an error."""
    registry.node(Needs)
    other = type("Needs", (Behavior,), {"__doc__": "Another.", "__module__": "elsewhere"})
    with pytest.raises(registry.RegistryError, match="already registered"):
        registry.node(other)


def test_G20_what_two_runs_are_called_does_not_differ(bench: Any) -> None:
    """py_trees: storage keys hold UUIDs, so logs of two runs do not diff; here nodes and keys go by their paths."""
    logs = []
    for _ in range(2):
        bench.events.__init__()
        bench.run("{sequence: [set: {n: 1}, probe: {script: RS}], out: {n: int}}")
        logs.append((bench.events.statuses, bench.events.writes))
    assert logs[0] == logs[1]
    assert logs[0][1] == [("main/n", 1)]


@pytest.mark.parametrize(
    ("body", "hint"),
    [
        ("parallel: {policy: succes_on_all, children: [{name: a, probe: {}}, {name: b, probe: {}}]}", "success_on_all"),
        ("sequnce: [probe: {}]", "sequence"),
        ("probe: {scrpt: S}", "script"),
        ("timeout: {after: ten, do: {probe: {}}}", ""),
        ("timeout: ten\nprobe: {}", ""),
        ("check: {that: countt > 1}", "count"),
        ("check: {that: count < 'x'}", ""),
        ("sequence: [part: {frm: 1}]", "from"),
    ],
)
def test_G21_what_the_xml_parser_lets_pass_is_refused_at_load(bench: Any, body: str, hint: str) -> None:
    """py_trees: misspelt policies and arguments are ignored, a bad duration fails at the first tick; here each is an error."""
    part = "part: {in: {from: {type: int, default: 0}}, probe: {}}" if "part" in body else ""
    program = bench.program(body, "keys: {count: {type: int, default: 0}}", part)
    errors = [d for d in program.diagnostics if d.severity == "error"]
    assert hint in f"{errors[0].message} {errors[0].hint}"


def test_G22_a_run_needs_no_signal_and_no_main_thread(bench: Any) -> None:
    """py_trees: `setup(timeout)` uses SIGUSR1 and fails in a worker thread; here nothing does, and handlers come back."""
    numbers = [signal.SIGUSR1, signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
    before = [signal.getsignal(number) for number in numbers]
    runner = bench.runner("probe: {script: RS}")
    thread = threading.Thread(target=runner.run)
    thread.start()
    thread.join()
    assert runner.outcome.status == "SUCCESS"
    assert bench.run("probe: {script: RX}").status == "ERROR"
    assert [signal.getsignal(number) for number in numbers] == before


class Ticking(VirtualClock):
    """A clock on which work and waking take time, and which remembers how long it was waited for."""

    def __init__(self, late: float = 0.0) -> None:
        super().__init__()
        self.late = late
        self.deadlines: list[float] = []

    def wait_until(self, deadline: float) -> None:
        self.deadlines.append(deadline)
        super().wait_until(deadline + self.late)


def test_G23_deadlines_are_absolute(bench: Any) -> None:
    """py_trees: sleeps a period after each tick, so 200 ticks of 20 ms end 46 ms late; here each tick has its own instant."""
    clock = Ticking(late=0.0003)
    outcome = bench.run("probe: {script: R}", clock=clock, period=0.02, max_ticks=200)
    assert clock.deadlines == pytest.approx([0.02 * k for k in range(200)])
    assert (outcome.overruns, [f for k, f in bench.events.notes if k == "overrun"]) == (0, [])


def test_G23_an_ended_task_is_not_ticked_again_and_waits_for_nothing(bench: Any) -> None:
    """py_trees: keeps ticking a SUCCESS root, or sleeps a whole period first; here the end is the end."""
    clock = Ticking()
    outcome = bench.run("probe: {script: RRS}", clock=clock)
    assert (outcome.ticks, len(clock.deadlines)) == (3, 3)


def test_G23_an_interrupt_before_the_first_tick_is_not_lost(bench: Any) -> None:
    """py_trees: `interrupt()` before `tick_tock` runs nothing and says nothing; here it is how the run ended."""
    runner = bench.runner("{name: a, probe: {script: R}, finally: [{name: end, probe: {}}]}")
    runner.interrupt("SIGINT")
    outcome = runner.run()
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", "stopped by SIGINT")
    assert bench.trace == ["end.init", "end.tick", "end.term(S)"]


def test_every_hazard_has_a_test() -> None:
    names = [name for name in globals() if name.startswith("test_G")]
    assert {int(name.split("_")[1][1:]) for name in names} == set(range(1, 24))
    assert all(globals()[name].__doc__.startswith("py_trees: ") for name in names)
    assert all("; here " in globals()[name].__doc__ for name in names)
    assert all(a < b for a, b in pairwise(sorted(names)))
