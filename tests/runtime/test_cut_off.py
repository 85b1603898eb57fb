"""A node that does not return after a signal is cut off: devices are stopped, `finally` runs, and the result names the node."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import pytest

from stretch_bt.behaviors import MotionBehavior
from stretch_bt.hardware.interfaces import Motion
from stretch_bt.runtime import cut_off
from stretch_bt.tree import registry
from stretch_bt.tree.ports import Behavior, In, Status

#: after which a node that nobody cut off gives up, s
LONG = 20.0
CUT = "its code did not return within {} s after a signal, and was cut off"


def lasting() -> Iterator[None]:
    """Go on for ever, but for a test that fails."""
    end = time.monotonic() + LONG
    while time.monotonic() < end:
        yield
    pytest.fail("nobody cut the node off")


def computing() -> None:
    for _ in lasting():
        pass


def sleeping() -> None:
    time.sleep(LONG)
    pytest.fail("nobody cut the node off")


def catching() -> None:
    for _ in lasting():
        with suppress(Exception):
            time.sleep(LONG)


def swallowing() -> None:
    for _ in lasting():
        try:  # noqa: SIM105  (as people write it)
            time.sleep(0.01)
        except:  # noqa: E722
            pass


def waiting_for_a_lock() -> None:
    lock = threading.Lock()
    lock.acquire()
    lock.acquire(timeout=LONG)
    pytest.fail("nobody cut the node off")


def waiting_for_a_child() -> None:
    subprocess.run(["sleep", str(LONG)], check=True)
    pytest.fail("nobody cut the node off")


WAYS = {f.__name__: f for f in (computing, sleeping, catching, swallowing, waiting_for_a_lock, waiting_for_a_child)}


class Hangs(Behavior):
    """Comes under a signal in one of its methods, and does not return from it."""

    instant: ClassVar[bool] = False
    way: In[str] = "computing"
    where: In[str] = "update"

    def _at(self, where: str) -> None:
        if where == self.where:
            os.kill(os.getpid(), signal.SIGINT)
            WAYS[self.way]()

    def initialise(self) -> None:
        self._at("initialise")

    def update(self) -> Status:
        self._at("update")
        if self.where == "terminate":
            os.kill(os.getpid(), signal.SIGINT)
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        self._at("terminate")


class HangsInStart(MotionBehavior):
    """Comes under a signal as it is to give its command."""

    def start(self) -> Motion:
        os.kill(os.getpid(), signal.SIGINT)
        computing()
        raise AssertionError


class TakesLong(Behavior):
    """Takes longer than a run that is to stop waits for a node."""

    seconds: In[float]

    def update(self) -> Status:
        time.sleep(self.seconds)
        return Status.SUCCESS


@pytest.fixture
def hangs(bench: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A bench with nodes that hang, and a short patience."""
    monkeypatch.setattr(cut_off, "PATIENCE", 0.05)
    for cls in (Hangs, HangsInStart, TakesLong):
        registry.node(cls)
    return bench


def cut(path: str) -> str:
    return f"{path}: {CUT.format(0.05)}"


@pytest.mark.parametrize("way", WAYS)
def test_it_is_cut_off_whatever_it_does(hangs: Any, way: str) -> None:
    devices = hangs.Devices()
    outcome = hangs.run(
        f"name: a\nhangs: {{way: {way}}}\nfinally: [{{name: end, probe: {{}}}}]", cell=devices, max_ticks=3
    )
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", f"stopped by SIGINT; {cut('main/a')}")
    assert (outcome.errors, devices.stops) == ([], 2)
    assert hangs.trace == ["end.init", "end.tick", "end.term(S)"]
    assert way in outcome.broken[0]["traceback"]
    assert hangs.events.of("interrupt") == [{"why": ["SIGINT"], "cut_off": "main/a"}]


@pytest.mark.parametrize("body", ["name: a\nhangs: {where: initialise}", "name: a\nhangs_in_start: {}"])
def test_it_is_cut_off_wherever_it_hangs(hangs: Any, body: str) -> None:
    outcome = hangs.run(body)
    assert (outcome.status, outcome.reason) == ("INTERRUPTED", f"stopped by SIGINT; {cut('main/a')}")


def test_an_end_that_does_not_return_keeps_no_device_moving(hangs: Any) -> None:
    devices = hangs.Devices()
    outcome = hangs.run("parallel: [{name: b, probe: {script: R}}, {name: a, hangs: {where: terminate}}]", cell=devices)
    assert (outcome.status, outcome.reason, devices.stops) == ("INTERRUPTED", "stopped by SIGINT", 2)
    assert outcome.errors == [cut("main/a")]
    assert hangs.trace[-1] == "b.term(I)", "and the others are ended"


def test_a_finally_that_does_not_return_is_cut_short(hangs: Any) -> None:
    outcome = hangs.run("probe: {}\nfinally: [{name: a, hangs: {}}]")
    assert outcome.status == "INTERRUPTED"
    assert outcome.errors == [f"finally: main/finally was cut short by SIGINT; {cut('main/finally/a')}"]


def test_a_finally_may_take_its_time_after_the_signal_that_ended_the_task(hangs: Any) -> None:
    outcome = hangs.run("probe: {script: i}\nfinally: [takes_long: {seconds: 0.2}]")
    assert (outcome.status, outcome.errors) == ("INTERRUPTED", [])


def test_what_the_host_had_of_the_alarm_comes_back(hangs: Any) -> None:
    rang: list[int] = []
    before = signal.signal(signal.SIGALRM, lambda number, _: rang.append(number))
    try:
        signal.setitimer(signal.ITIMER_REAL, 100.0, 7.0)
        hangs.run("hangs: {}")
        rest, interval = signal.getitimer(signal.ITIMER_REAL)
        assert 90.0 < rest < 100.0
        assert interval == 7.0
        os.kill(os.getpid(), signal.SIGALRM)
        assert rang == [signal.SIGALRM]
        signal.setitimer(signal.ITIMER_REAL, 0.01)  # due while the run has the alarm
        hangs.run("hangs: {}")
        end = time.monotonic() + LONG
        while len(rang) < 2:
            assert time.monotonic() < end
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_a_run_beside_the_main_thread_touches_no_alarm(hangs: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signal, "setitimer", None)
    runner = hangs.runner("sequence: [takes_long: {seconds: 0.2}, probe: {script: R}]")
    thread = threading.Thread(target=runner.run)
    thread.start()
    runner.interrupt("the host")
    thread.join()
    assert runner.outcome.reason == "stopped by the host"


TREE = """\
format: stretch-tree/1
imports: {own: own}
devices: {arm: Arm}
scene: ball.yaml
trees:
  main:
    sequence: [{name: spins, forever: {}}]
    finally: [retract: {clearance: 20 mm}]
"""
BALL = "format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, stiffness: 2 N/mm}\nfidelity: hertz\n"
OWN = """\
import time
from pathlib import Path
from stretch_bt import Behavior, Status, node

@node
class Forever(Behavior):
    \"\"\"Never returns.\"\"\"
    def update(self):
        Path("began").touch()
        while True:
            time.sleep(0.01)
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in {"tree.yaml": TREE, "ball.yaml": BALL, "own.py": OWN}.items():
        Path(name).write_text(text)


def begun(*words: str) -> subprocess.Popen[bytes]:
    """Return a command whose node hangs by now."""
    Path("began").unlink(missing_ok=True)
    process = subprocess.Popen([sys.executable, "-m", "stretch_bt", *words], stdout=subprocess.PIPE)
    end = time.monotonic() + 60
    while not Path("began").exists():
        assert time.monotonic() < end
        time.sleep(0.02)
    return process


def test_a_command_ends_as_after_any_signal_and_its_record_replays(own: None) -> None:
    with begun("run", "tree.yaml", "-q", "--json", "--out", "record") as run:
        run.send_signal(signal.SIGTERM)
        told, _ = run.communicate(timeout=60)
    assert run.returncode == 130
    result = json.loads(told)
    assert (result["status"], result["errors"]) == ("INTERRUPTED", [])
    assert result["reason"] == f"stopped by SIGTERM; main/spins: {CUT.format(1)}"
    assert result["broken"][0]["at"].startswith("own.py:")
    events = [json.loads(line) for line in Path("record/events.jsonl").read_text().splitlines()]
    assert {"main/finally/retract"} <= {e["path"] for e in events if e["type"] == "status"}
    with begun("replay", "record", "--trust", "--json") as again:
        told, _ = again.communicate(timeout=60)
    assert json.loads(told)["identical"]
