"""Signals that a node takes away from the run are taken back, and the node is named once."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from stretch_bt.clock import RealClock
from stretch_bt.runtime import hearing
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Status


def ignoring() -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def handling() -> None:
    signal.signal(signal.SIGTERM, lambda *_: None)


def blocking() -> None:
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())


WAYS = {f.__name__: f for f in (ignoring, handling, blocking)}


class TakesSignals(Behavior):
    """Takes signals away on each tick, and gets one after some."""

    instant: ClassVar[bool] = False
    way: In[str] = "ignoring"

    def initialise(self) -> None:
        self.count = 0

    def update(self) -> Status:
        self.count += 1
        if self.count % 4 == 0:
            os.kill(os.getpid(), signal.SIGTERM)
        WAYS[self.way]()
        return Status.RUNNING


@pytest.fixture
def takes(bench: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    registry.node(TakesSignals)
    monkeypatch.setattr(hearing, "EVERY", 0.0)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    yield bench
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@pytest.mark.parametrize("way", WAYS)
def test_the_run_is_stopped_all_the_same_and_the_node_is_named(takes: Any, way: str) -> None:
    outcome = takes.run(f"parallel: [{{name: a, takes_signals: {{way: {way}}}}}, {{name: b, wait: {{duration: 9 s}}}}]")
    assert (outcome.status, outcome.reason, outcome.ticks) == ("INTERRUPTED", "stopped by SIGTERM", 4)
    [note] = outcome.notes
    assert note.startswith("warning: main/a set a handler of ")
    assert "SIGTERM" in note


def test_nodes_that_might_have_done_it_are_all_named(takes: Any) -> None:
    outcome = takes.run(
        "sequence: [{name: c, probe: {}}, {name: d, wait: {duration: 200 ms}}, "
        "parallel: [{name: a, takes_signals: {}}, {name: b, probe: {script: R}}]]"
    )
    assert outcome.notes[0].startswith("warning: one of main/a, main/b set")


def test_after_the_first_time_every_tick_is_looked_at(takes: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[int] = []
    monkeypatch.setattr(hearing, "EVERY", 3600.0)

    def put_back() -> list[str]:
        looks.append(1)
        return ["SIGTERM"]

    monkeypatch.setattr(hearing, "put_back", put_back)
    takes.run("probe: {script: RRRS}")
    assert len(looks) == 5, "of 4 ticks, and before the end"


def test_what_was_blocked_before_stays_blocked(takes: Any) -> None:
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGHUP])
    outcome = takes.run("takes_signals: {way: ignoring}")
    assert signal.SIGHUP in signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGHUP])
    assert outcome.reason == "stopped by SIGTERM"


def test_handlers_of_the_host_come_back(takes: Any) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    takes.run("takes_signals: {way: handling}")
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_it_is_looked_at_now_and_then(takes: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    looks: list[int] = []
    monkeypatch.setattr(hearing, "EVERY", 0.05)
    monkeypatch.setattr(hearing, "put_back", lambda: looks.append(1))
    runner = takes.runner("probe: {script: R}", clock=RealClock(), period=0.005, max_ticks=40)
    runner.run()
    assert 1 < len(looks) <= 10


def test_shipped_nodes_are_trusted(takes: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "put_back", None)
    assert takes.run("wait: {duration: 1 s}").status == "SUCCESS"


def test_a_run_beside_the_main_thread_leaves_signals_alone(takes: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "put_back", None)
    runner = takes.runner("probe: {script: RS}")
    thread = threading.Thread(target=runner.run)
    thread.start()
    thread.join()
    assert runner.outcome.status == "SUCCESS"


TREE = """\
format: stretch-tree/1
imports: {own: own}
trees: {main: {name: deaf, goes_deaf: {}}}
"""
OWN = """\
import signal, time
from pathlib import Path
from stretch_bt import Behavior, Status, node

signal.signal(signal.SIGINT, signal.SIG_IGN)

@node
class GoesDeaf(Behavior):
    \"\"\"Ignores signals.\"\"\"
    instant = False
    count = 0
    def initialise(self):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    def update(self):
        time.sleep(0.01)
        self.count += 1
        if self.count == 20:
            Path("began").touch()
        return Status.RUNNING
"""


def test_ctrl_c_ends_a_command_whose_node_ignores_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tree.yaml").write_text(TREE)
    Path("own.py").write_text(OWN)
    command = [sys.executable, "-m", "stretch_bt", "run", "tree.yaml", "-q", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as run:
        end = time.monotonic() + 60
        while not Path("began").exists():
            assert time.monotonic() < end
            time.sleep(0.02)
        run.send_signal(signal.SIGINT)
        told, _ = run.communicate(timeout=60)
    result = json.loads(told)
    assert (run.returncode, result["reason"]) == (130, "stopped by SIGINT")
    assert result["notes"] == [
        "warning: main/deaf set a handler of SIGINT or blocked it; the run took it back, for a stop must be heard"
    ]
