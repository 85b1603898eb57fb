"""palpate_stiffness stopped at any tick, by signals and by nodes that break: it always comes to the same safe end."""

import itertools
import json
import os
import random
import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.hardware.interfaces import DeviceState
from stretch_bt.runtime.record import RecordReader
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import RunResult, run
from stretch_bt.tree.flow import FlowNode

pytestmark = pytest.mark.hard

TREE = "palpate_stiffness"
WAYS = ("SIGINT", "SIGTERM", "update", "terminate")
MOCKS = """\
format: stretch-mocks/1
tree: palpate_stiffness
readings: {arm.force: 1 N}
mocks:
  - {match: "**/set_stretch", after: 150 ms}
  - {match: "**/approach", after: 500 ms, outputs: {touch: {height: 100 mm, height_sd: 0.01 mm}}}
  - {match: "**/press", after: 200 ms}
  - {match: "**/average_frames", after: 100 ms, outputs: {frame: {}}}
  - {match: "**/segment_contact", outputs: {contact: {}}}
  - match: main/feel_first/track_height
    outputs: {observed_top: {height: 99.1 mm, height_sd: 0.05 mm, fixed_sd: 0 mm, by_membrane: false}}
  - match: main/until/feel/track_height
    outputs: {observed_top: {height: 96.9 mm, height_sd: 0.05 mm, fixed_sd: 0 mm, by_membrane: false}}
  - {match: "**/fit_sphere", outputs: {sphere: {radius: 30 mm, radius_sd: 0.2 mm}}}
  - {match: "**/retract", after: 250 ms}
"""

CELL = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated, height: 70 mm}
  gripper: {type: Gripper, use: simulated}
  camera: {type: DepthCamera, use: simulated, rate: 10 Hz}
limits: {height: {min: -1 m, max: 1 m}, depth: 30 mm}
"""


class Trouble:
    """Makes trouble once, at a tick or as soon after it as it can, and counts the starts and the stops of nodes."""

    def __init__(self, way: str, tick: int) -> None:
        self.way = way
        self.tick = tick
        self.made = False
        self.stopping = False
        self.starts: Counter[str] = Counter()
        self.stops: Counter[str] = Counter()
        self.running: set[str] = set()
        self.left_running: list[str] = []
        self.too_many: list[str] = []

    def watch(self, runner: Any) -> None:
        """Put itself around the leaves of a tree that is about to be run."""
        self.runner = runner
        self.leaves = {path: node for path, node in runner.tree.nodes.items() if not node.children}
        for path, node in self.leaves.items():
            mocked = isinstance(node, FlowNode)
            start, stop, work = ("begin", "stop", "decide") if mocked else ("initialise", "terminate", "update")
            setattr(node, start, self._counted(self.starts, path, getattr(node, start)))
            setattr(node, stop, self._breaking(path, getattr(node, stop)))
            setattr(node, work, self._broken_work(getattr(node, work), mocked))
        runner.watchers.append(self)

    def _counted(self, counter: Counter[str], path: str, call: Callable[[], None]) -> Callable[[], None]:
        def counted() -> None:
            counter[path] += 1
            call()

        return counted

    def _breaking(self, path: str, call: Callable[..., None]) -> Callable[..., None]:
        def stop(status: Any) -> None:
            self.stops[path] += 1
            if self.stops[path] > self.starts[path]:
                self.too_many.append(path)
            call(status)
            if self.way == "terminate":
                self._break()

        return stop

    def _broken_work(self, call: Callable[[], Any], mocked: bool) -> Callable[[], Any]:
        def update() -> Any:
            if self.way == "update":
                self._break()
            return call()

        def decide() -> Iterator[Any]:
            if self.way == "update":
                self._break()
            return (yield from call())

        return decide if mocked else update

    def _break(self) -> None:
        if not self.made and self.runner.context.ticks >= self.tick:
            self.made = True
            raise RuntimeError("made to break")

    def begin_tick(self, tick: int, time: float) -> None:
        if tick == self.tick and self.way in ("SIGINT", "SIGTERM", "terminate"):
            self.made = self.way != "terminate"
            os.kill(os.getpid(), signal.SIGTERM if self.way == "SIGTERM" else signal.SIGINT)

    def status(self, path: str, status: str, reason: str = "") -> None:
        (self.running.add if status == "RUNNING" else self.running.discard)(path)

    def write(self, *_: Any) -> None:
        pass

    def note(self, kind: str, **fields: Any) -> None:
        if kind == "stop":
            self.left_running = sorted(self.running & set(self.leaves))
            self.before = Counter(self.stops)
            self.at = self.runner.context.ticks


def stopped(way: str, tick: int, folder: Path, **options: Any) -> tuple[Trouble, RunResult]:
    trouble = Trouble(way, tick)
    result = run(TREE, out=folder, watch=trouble.watch, **options)
    return trouble, result


def check_end(trouble: Trouble, result: RunResult) -> None:
    """Check every end: each node stopped once, `finally` ran, devices at rest, the record closed."""
    in_task = trouble.tick < trouble.at or (trouble.tick == trouble.at and result.status != "SUCCESS")
    if in_task and trouble.made:
        ends = {"update": {"ERROR"}, "terminate": {"INTERRUPTED", "ERROR"}}
        assert result.status in ends.get(trouble.way, {"INTERRUPTED"})
    assert trouble.too_many == []
    for path, node in trouble.leaves.items():
        told = trouble.stops[path] - trouble.before[path]
        if not isinstance(node, FlowNode):
            assert trouble.starts[path] == trouble.stops[path], f"{path}: a start without an end"
        elif path in trouble.left_running:
            assert told == 1, f"{path} was stopped {told} times"
        assert node.status.name in ("INVALID", "SUCCESS", "FAILURE")
    check_record(trouble, result)
    if trouble.runner.cell is not None:
        check_at_rest(trouble.runner.cell)


def check_record(trouble: Trouble, result: RunResult) -> None:
    folder = Path(result.record)
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text("utf-8").splitlines()]
    retracted = any(
        e.get("path") == "main/finally/retract" and e["status"] == "SUCCESS" for e in events if "status" in e
    )
    assert retracted or any(e["type"] == "finally" for e in events)
    assert retracted or trouble.tick >= trouble.at, "only trouble during `finally` keeps it from its end"
    stop = next(n for n, e in enumerate(events) if e["type"] == "stop")
    owners = {e["owner"] for e in events[stop:] if e["type"] == "command" and e["name"] != "stop"}
    assert owners <= {"main/finally/retract"}
    assert json.loads((folder / "result.json").read_text("utf-8"))["status"] == result.status
    assert RecordReader(folder).complete


def check_at_rest(cell: Any) -> None:
    twin, now = cell._context.twin, cell._context.now()
    for name, device in cell.devices.items():
        assert (name, device.state) == (name, DeviceState.DISCONNECTED)
        assert getattr(device, "_current", None) is None
    braked, later = (twin.hand.at(now + t).true for t in (1.0, 2.0))
    assert braked == later
    assert twin.hand.at(now).true.height == pytest.approx(later.height, abs=0.02**2 / (2 * 0.5) + 1e-9)
    assert twin.fingers.at(now + 1.0) == twin.fingers.at(now + 2.0)


def check_replay(trouble: Trouble, result: RunResult) -> None:
    """A run that signals stopped replays alike; one that was sabotaged from outside replays alike up to there."""
    again = replay(result.record)
    if trouble.way in ("SIGINT", "SIGTERM") or not trouble.made:
        assert again.identical, again.first_difference
    else:
        assert not again.identical
        assert again.first_difference is not None
        assert again.first_difference["tick"] >= trouble.tick


@pytest.mark.parametrize(
    ("ways", "every"), [(1, 10), *(pytest.param(*case, marks=pytest.mark.slow) for case in ((1, 5), (4, 1)))]
)
def test_ticks_under_mocks(ways: int, every: int, tmp_path: Path) -> None:
    """Every tenth or fifth tick in one way, in turn; or each in all four."""
    (tmp_path / "mocks.yaml").write_text(MOCKS, encoding="utf-8")
    mocks = tmp_path / "mocks.yaml"
    rests = {"settle": 1.5}  # where nothing is done, more ticks show nothing
    whole = run(TREE, mocks=mocks, params=rests, out=tmp_path / "whole")
    assert (whole.status, 60 <= whole.ticks <= 200) == ("SUCCESS", True)
    made: Counter[str] = Counter()
    for tick, k in itertools.product(range(1, whole.ticks + 1, every), range(ways)):
        way = WAYS[(tick // every + k) % 4]
        trouble, result = stopped(way, tick, tmp_path / f"{way}{tick}", mocks=mocks, params=rests)
        check_end(trouble, result)
        made[way] += trouble.made
        if tick // every % 8 == k:
            check_replay(trouble, result)
    asked = len(range(1, whole.ticks + 1, every)) * ways // 4
    assert made["SIGINT"] in (asked, asked + 1)
    assert made["SIGTERM"] in (asked, asked + 1)
    assert min(made.values()) > 0.85 * asked


@pytest.fixture(scope="module")
def small_twin(tmp_path_factory: pytest.TempPathFactory, at_hertz: Callable[[str, Path], Path]) -> dict[str, Any]:
    """A cell that begins close above the object and takes fewer frames: the same task in half the ticks."""
    folder = tmp_path_factory.mktemp("cell")
    (folder / "small.yaml").write_text(CELL, encoding="utf-8")
    params = {"frames": 2, "touch_frames": 4, "sensing_frames": 4, "min_hold": 0.0, "settle": 0.0, "model": "paper"}
    return {"cell": folder / "small.yaml", "scene": at_hertz("water_balloon", folder), "params": params}


@pytest.mark.parametrize("numbers", [(3,), pytest.param((0, 1, 2), marks=pytest.mark.slow)])
def test_four_ticks_in_the_twin(tmp_path: Path, small_twin: dict[str, Any], numbers: tuple[int, ...]) -> None:
    whole = run(TREE, out=tmp_path / "whole", **small_twin)
    assert whole.status == "SUCCESS"
    chosen = sorted(random.Random(7).sample(range(1, whole.ticks), 4))
    for number in numbers:
        tick = chosen[number]
        trouble, result = stopped(WAYS[number % 4], tick, tmp_path / str(tick), **small_twin)
        assert trouble.made
        check_end(trouble, result)
        if number in (0, 3):
            check_replay(trouble, result)


@pytest.mark.slow
@pytest.mark.parametrize("cell", ["small", "shipped"])
def test_every_tick_in_the_twin(
    cell: str, tmp_path: Path, small_twin: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """Every tick of the task, the four ways in turn; prints its figures."""
    options = small_twin if cell == "small" else {}
    began = time.process_time()
    whole = run(TREE, out=tmp_path / "whole", **options)
    failures, ends = [], Counter()
    for tick in range(1, whole.ticks + 1):
        way = WAYS[tick % 4]
        trouble, result = stopped(way, tick, tmp_path / "run", **options)
        ends[way, result.status] += 1
        try:
            check_end(trouble, result)
            check_replay(trouble, result)
        except AssertionError as error:
            failures.append(f"{way} at tick {tick}: {error}")
        shutil.rmtree(tmp_path / "run")
    seconds = time.process_time() - began
    with capsys.disabled():
        print(f"\n{cell} cell: {whole.ticks} runs stopped and replayed, {len(failures)} failures, {seconds:.0f} s")  # noqa: T201
        for (way, status), count in sorted(ends.items()):
            print(f"  {way:9s} {status:11s} {count}")  # noqa: T201
    assert failures == []
