"""How tasks end: nodes that break in every way, interrupts, ends that are owed, watchers and clocks that fail."""

import os
import signal
import threading
from typing import Any

import pytest

from stretch_bt import clock as clock_module
from stretch_bt.clock import RealClock, ReplayClock, VirtualClock
from stretch_bt.errors import DeviceFault
from stretch_bt.runtime.safe_end import FINALLY_LIMIT

pytestmark = pytest.mark.hard

ENDING = "{{name: a, probe: {{script: {0}}}, finally: [{{name: end, probe: {{script: {1}, stop_script: '{2}'}}}}]}}"
CALLED = {
    "body": "{sequence: [outer: {}], finally: [{name: last, probe: {}}]}",
    "trees": """
        outer: {sequence: [inner: {}], finally: [{name: outer_end, probe: {}}]}
        inner: {name: a, probe: {script: RRi}, finally: [{name: inner_end, probe: {}}]}
    """,
}


@pytest.mark.parametrize(
    ("task", "end", "stop", "status", "reason"),
    [
        ("S", "S", "", "SUCCESS", ""),
        ("F", "S", "", "FAILURE", "main/a: failed"),
        ("C", "S", "", "FAILURE", "main/a: the numbers carry no answer"),
        ("X", "S", "", "ERROR", "main/a: RuntimeError: broken"),
        ("D", "S", "", "FAULT", "main/a: arm: the arm says no"),
        ("K", "S", "", "INTERRUPTED", "main/a: KeyboardInterrupt: "),
        ("Q", "S", "", "ERROR", "main/a: SystemExit: 3"),
        ("i", "S", "", "INTERRUPTED", "stopped by SIGINT"),
        ("b", "S", "", "INTERRUPTED", "stopped by SIGINT"),
        ("S", "F", "", "FAILURE", "the task was done, but its finally failed: main/finally/end: failed"),
        ("S", "X", "", "ERROR", "the task was done, but its finally failed: main/finally/end: RuntimeError: broken"),
        ("S", "N", "", "ERROR", "the task was done, but its finally failed: main/finally/end: update() returned None;"),
        ("S", "D", "", "FAULT", "the task was done, but its finally failed: main/finally/end: arm: the arm says no"),
        ("S", "R", "", "FAILURE", "the task was done, but its finally failed: main/finally did not end within 60 s"),
        ("S", "b", "", "INTERRUPTED", "the task was done, but its finally failed: main/finally was cut short"),
        ("S", "i", "", "INTERRUPTED", "the task was done, but its finally failed: main/finally was cut short"),
        ("S", "K", "", "INTERRUPTED", "the task was done, but its finally failed: main/finally/end: KeyboardInterrupt"),
        ("S", "Q", "", "ERROR", "the task was done, but its finally failed: main/finally/end: SystemExit: 3"),
        ("F", "D", "", "FAULT", "main/a: failed; its finally failed: main/finally/end: arm: the arm says no"),
        ("F", "F", "", "FAILURE", "main/a: failed"),
        ("X", "D", "", "ERROR", "main/a: RuntimeError: broken"),
        ("S", "R", "X", "ERROR", "the task was done, but its finally failed: main/finally did not end within 60 s"),
        ("S", "S", "X", "ERROR", "the task was done, but its finally failed: main/finally/end: terminate() broke"),
    ],
)
def test_how_task_and_finally_end_together(
    bench: Any, task: str, end: str, stop: str, status: str, reason: str
) -> None:
    devices = bench.Devices()
    outcome = bench.run(ENDING.format(task, end, stop), cell=devices)
    assert outcome.status == status
    assert outcome.reason.startswith(reason)
    assert bool(outcome.reason) == (status != "SUCCESS")
    for name in ("a", "end"):
        assert bench.trace.count(f"{name}.init") == 1
        assert sum(entry.startswith(f"{name}.term") for entry in bench.trace) == 1
    assert devices.stops == (1 if task in "SFC" else 2)
    assert len(bench.events.of("finally")) == (end != "S" or bool(stop))
    assert [note["status"] for note in bench.events.of("stop")] == [outcome.status if task != "S" else "SUCCESS"] or (
        task == "F" and end == "D"
    )


def test_a_finally_that_never_ends_is_given_a_bounded_time(bench: Any) -> None:
    outcome = bench.run(ENDING.format("S", "R", ""), period=1.0)
    assert outcome.task_seconds == pytest.approx(FINALLY_LIMIT)
    assert bench.trace[-1] == "end.term(I)"


@pytest.mark.parametrize(("second", "ticks"), [("SIGINT", 2), ("SIGTERM", 2)])
def test_a_second_interrupt_cuts_finally_short(bench: Any, second: str, ticks: int) -> None:
    letter = {"SIGINT": "i", "SIGTERM": "t"}[second]
    devices = bench.Devices()
    outcome = bench.run(ENDING.format("i", f"{letter}R", ""), cell=devices)
    assert (outcome.status, outcome.ticks) == ("INTERRUPTED", ticks)
    assert outcome.errors == [f"finally: main/finally was cut short by {second}"]
    assert bench.trace[-1] == "end.term(I)"
    assert devices.stops == 2
    assert bench.events.of("interrupt") == [{"why": ["SIGINT"]}, {"why": [second]}]


def test_two_interrupts_before_the_first_tick_leave_finally_out(bench: Any) -> None:
    runner = bench.runner(ENDING.format("R", "R", ""), cell=(devices := bench.Devices()))
    runner.interrupt("SIGINT")
    runner.interrupt("SIGINT")
    outcome = runner.run()
    assert (outcome.status, outcome.ticks, bench.trace, devices.stops) == ("INTERRUPTED", 0, [], 2)
    assert outcome.errors == ["finally: main/finally was not run: stopped twice"]


def test_an_interrupt_from_another_thread_ends_the_wait(bench: Any) -> None:
    runner = bench.runner(ENDING.format("R", "S", ""), clock=RealClock(), period=60.0)
    threading.Thread(target=lambda: _when_waiting(runner)).start()
    outcome = runner.run()
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", "stopped by a test")
    assert (outcome.ticks, bench.trace[-1]) == (2, "end.term(S)")
    assert runner.clock.now() < 60.0, "neither the task nor its `finally` waits for the next tick"


def _when_waiting(runner: Any) -> None:
    while runner.context.ticks < 1:
        threading.Event().wait(0.001)
    runner.interrupt("a test")


def test_every_finally_that_is_owed_runs_from_the_inside_out(bench: Any) -> None:
    outcome = bench.run(CALLED["body"], trees=CALLED["trees"])
    assert outcome.status == "INTERRUPTED"
    starts_and_stops = [entry for entry in bench.trace if entry.endswith(("term(I)", "init"))]
    assert starts_and_stops == ["a.init", "a.term(I)", "inner_end.init", "outer_end.init", "last.init"]


#: a tree whose `finally` calls trees with a `finally` of their own, three deep; the innermost ends as {0} says
DEEP = {
    "body": "{name: a, probe: {}, finally: [outer: {}, {name: last, probe: {}}]}",
    "trees": """
        outer: {{sequence: [inner: {{}}], finally: [{{name: outer_end, probe: {{}}}}]}}
        inner: {{name: b, probe: {{script: {0}}}, finally: [core: {{}}]}}
        core: {{name: c, probe: {{script: {1}}}, finally: [{{name: core_end, probe: {{}}}}]}}
    """,
}


@pytest.mark.parametrize(("inner", "core"), [(b, c) for b in "FXDKQi" for c in "SFXDQ"])
def test_every_tree_that_a_finally_calls_runs_its_own_whatever_breaks_in_it(bench: Any, inner: str, core: str) -> None:
    outcome = bench.run(DEEP["body"], trees=DEEP["trees"].format(inner, core))
    assert outcome.status != "SUCCESS"
    begun = [entry.partition(".")[0] for entry in bench.trace if entry.endswith(".init")]
    assert [begun.count(name) for name in ("b", "core_end", "outer_end")] == [1, begun.count("c"), 1], begun
    assert begun.index("b") < begun.index("c") < begun.index("core_end") < begun.index("outer_end")


def test_a_finally_in_a_task_that_calls_trees_leaves_none_of_theirs_out(bench: Any) -> None:
    bench.run("sequence: [outer: {}]", trees=DEEP["trees"].format("S", "X"))
    begun = [entry.partition(".")[0] for entry in bench.trace if entry.endswith(".init")]
    assert begun.count("core_end") == begun.count("c") > 0
    assert begun.count("outer_end") == 1


def test_a_finally_that_ran_with_its_call_is_not_run_again(bench: Any) -> None:
    outcome = bench.run(
        "sequence: [part: {}, {name: b, probe: {script: Ri}}]",
        trees="part: {name: a, probe: {script: RS}, finally: [{name: end, probe: {script: RS}}]}",
    )
    assert (outcome.status, bench.trace.count("end.init")) == ("INTERRUPTED", 1)


def test_a_reason_names_the_construct_whose_expression_broke(bench: Any) -> None:
    outcome = bench.run("sequence: [set: {n: 0}, check: {that: 1 / n > 0, name: ratio}]", "keys: {n: int}")
    assert outcome.status == "ERROR"
    assert outcome.reason == "main/ratio: 1 / 0 is no finite number; guard it with a comparison"


@pytest.mark.parametrize("error", [DeviceFault("arm", "will not stop"), OSError("broken"), KeyboardInterrupt()])
def test_devices_that_do_not_stop_are_told_again_and_reported(bench: Any, error: BaseException) -> None:
    devices = bench.Devices(error)
    outcome = bench.run(ENDING.format("i", "S", ""), cell=devices)
    assert (outcome.status, devices.stops, len(outcome.errors)) == ("INTERRUPTED", 2, 1)
    assert bench.trace[-1] == "end.term(S)"
    outcome = bench.run(ENDING.format("S", "S", ""), cell=bench.Devices(error))
    assert outcome.status in ("FAULT", "ERROR", "INTERRUPTED")


class Failing:
    """A watcher that breaks from some tick on."""

    def __init__(self, tick: int) -> None:
        self.tick = tick
        self.at = 0

    def begin_tick(self, tick: int, time: float) -> None:
        self.at = tick
        self._check()

    def status(self, path: str, status: str, reason: str = "") -> None:
        self._check()

    def write(self, key: str, value: Any, sd: float | None, path: str) -> None:
        self._check()

    def note(self, kind: str, **fields: Any) -> None:
        self._check()

    def _check(self) -> None:
        if self.at >= self.tick:
            raise OSError("the disk is full")


def test_a_record_that_fails_stops_the_task_but_not_its_safe_end(bench: Any) -> None:
    devices = bench.Devices()
    outcome = bench.run(ENDING.format("R", "S", ""), cell=devices, watchers=[Failing(3), bench.events])
    assert (outcome.status, outcome.reason) == ("ERROR", "OSError: the disk is full")
    assert outcome.errors == ["Failing: the disk is full"]
    assert bench.trace[-4:] == ["a.term(I)", "end.init", "end.tick", "end.term(S)"]
    assert devices.stops == 2
    assert bench.events.of("stop") == [{"status": "ERROR", "reason": "OSError: the disk is full"}]


def test_what_was_interrupted_is_told_before_finally_begins(bench: Any) -> None:
    bench.run(ENDING.format("Ri", "S", ""))
    assert [(path, status) for _, path, status, _ in bench.events.statuses] == [
        ("main/a", "RUNNING"),
        ("main/a", "INVALID"),
        ("main/finally/end", "SUCCESS"),
        ("main/finally/sequence", "SUCCESS"),
    ]


class Slow(VirtualClock):
    """A clock on which each tick takes as long as a script says."""

    def __init__(self, *work: float) -> None:
        super().__init__()
        self.work = list(work)
        self.deadlines: list[float] = []
        self.asked = 0

    def wait_until(self, deadline: float) -> None:
        self.deadlines.append(deadline)
        super().wait_until(deadline)

    def begin_tick(self, tick: int, time: float) -> None:
        self._now += self.work.pop(0) if self.work else 0.0

    def status(self, *arguments: Any) -> None:
        pass

    def write(self, *arguments: Any) -> None:
        pass

    def note(self, *arguments: Any, **fields: Any) -> None:
        pass


@pytest.mark.parametrize(
    ("work", "deadlines", "overruns", "worst"),
    [
        ([0.9, 0.9, 0.9], [0, 1, 2, 3, 4], 0, 0.0),
        ([0.0, 1.5], [0, 1, 3, 4, 5], 1, 0.5),
        ([3.25, 0.0, 1.25], [0, 4, 5, 7, 8], 2, 2.25),
        ([1.0], [0, 1, 2, 3, 4], 0, 0.0),
    ],
)
def test_an_overrun_is_counted_told_and_not_caught_up_with(
    bench: Any, work: list[float], deadlines: list[float], overruns: int, worst: float
) -> None:
    clock = Slow(*work)
    outcome = bench.run("probe: {script: R}", clock=clock, period=1.0, max_ticks=5, watchers=[clock, bench.events])
    assert clock.deadlines == pytest.approx(deadlines)
    assert (outcome.overruns, outcome.worst_overrun) == (overruns, pytest.approx(worst))
    assert len(bench.events.of("overrun")) == overruns


class Spurious(VirtualClock):
    """A clock whose waits end early three times."""

    def __init__(self) -> None:
        super().__init__()
        self.waits = 0

    def wait_until(self, deadline: float) -> None:
        self.waits += 1
        self._now = min(deadline, self._now + 0.25)


def test_a_wake_up_for_nothing_does_not_tick_early(bench: Any) -> None:
    clock = Spurious()
    bench.run("probe: {script: R}", clock=clock, period=1.0, max_ticks=3)
    assert bench.events.ticks == [(1, 0.0), (2, 1.0), (3, 2.0)]
    assert clock.waits == 1 + 4 + 4


def test_a_wake_up_ends_a_wait_at_once_from_a_signal_handler_too() -> None:
    clock = RealClock()
    before = signal.signal(signal.SIGALRM, lambda *_: clock.wake())
    try:
        for _ in range(200):
            signal.setitimer(signal.ITIMER_REAL, 1e-4)
            clock.wait_until(clock.now() + 60.0)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert clock.now() < 60.0


def test_a_wake_up_from_another_thread_ends_a_long_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock_module, "LONGEST", 3600.0)
    clock = RealClock()
    threading.Timer(0.01, clock.wake).start()
    clock.wait_until(60.0)
    assert clock.now() < 60.0


def test_a_signal_that_another_thread_catches_ends_a_wait_too(bench: Any) -> None:
    runner = bench.runner("name: a\nprobe: {script: R}", clock=RealClock(), period=60.0)
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
    try:
        sender = threading.Thread(target=_kill_when_waiting, args=(runner,))
        sender.start()
        outcome = runner.run()
        sender.join()
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", "stopped by SIGTERM")
    assert runner.clock.now() < 60.0


def _kill_when_waiting(runner: Any) -> None:
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
    while runner.context.ticks < 1:
        threading.Event().wait(0.001)
    os.kill(os.getpid(), signal.SIGTERM)


def test_the_clock_of_a_run_begins_with_its_first_tick(bench: Any) -> None:
    outcome = bench.run("probe: {script: RRS}", clock=ReplayClock([7.5, 7.55, 7.625]))
    assert (outcome.task_seconds, bench.events.ticks[0]) == (pytest.approx(0.125), (1, 7.5))
