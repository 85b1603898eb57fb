import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stretch_bt.clock import ReplayClock, VirtualClock
from stretch_bt.runtime import execute
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import run
from stretch_bt.testing.short_runs import short_runs
from stretch_bt.tree.ports import Status


@pytest.fixture
def jobs(tmp_path: Path) -> dict[str, dict[str, Any]]:
    """A run in the twin and one under mocks, as arguments of `run`."""
    return short_runs(tmp_path)


def log_of(job: dict[str, Any], out: Path, seed: int = 0) -> bytes:
    result = run(**job, out=out, seed=seed)
    assert result.status == "SUCCESS", result.reason
    return (out / "events.jsonl").read_bytes()


@pytest.mark.parametrize("name", ["twin", "mocks"])
def test_the_same_seed_gives_the_same_log_in_one_process(
    jobs: dict[str, dict[str, Any]], name: str, tmp_path: Path
) -> None:
    logs = [log_of(jobs[name], tmp_path / str(n)) for n in range(2)]
    assert logs[0] == logs[1]
    assert len(logs[0].splitlines()) > 20


def test_another_seed_gives_other_readings(jobs: dict[str, dict[str, Any]], tmp_path: Path) -> None:
    records = [tmp_path / str(seed) for seed in range(2)]
    first, second = (log_of(jobs["twin"], out, seed) for seed, out in enumerate(records))
    assert first != second
    assert first.splitlines()[1:] != second.splitlines()[1:], "not only the seed in the header"


def test_fresh_processes_with_other_hash_seeds_give_the_same_log(
    jobs: dict[str, dict[str, Any]], at_hertz: Callable[[str, Path], Path], tmp_path: Path
) -> None:
    jobs["twin"]["scene"] = at_hertz("water_balloon", tmp_path)
    asked = {name: {key: str(value) for key, value in job.items()} for name, job in jobs.items()}
    digests: dict[str, set[str]] = {name: set() for name in jobs}
    for hash_seed in ("1", "4242"):
        out = tmp_path / hash_seed
        calls = "; ".join(f"run(**{job!r}, out={str(out / name)!r})" for name, job in asked.items())
        env = {**os.environ, "PYTHONHASHSEED": hash_seed}
        code = f"from stretch_bt.runtime.task import run; {calls}"
        subprocess.run([sys.executable, "-c", code], check=True, env=env, cwd=tmp_path, timeout=120)
        for name, seen in digests.items():
            seen.add(hashlib.sha256((out / name / "events.jsonl").read_bytes()).hexdigest())
    for name, seen in digests.items():
        seen.add(hashlib.sha256(log_of(jobs[name], tmp_path / name)).hexdigest())
        assert len(seen) == 1, name


def test_nothing_of_the_place_or_the_hour_is_in_the_log(jobs: dict[str, dict[str, Any]], tmp_path: Path) -> None:
    log = log_of(jobs["twin"], tmp_path / "out").decode()
    assert str(tmp_path) not in log
    assert os.uname().nodename not in log
    assert '"time":0.0' in log


def test_two_trees_ticked_in_turn_do_not_see_each_other(bench: Any) -> None:
    body = """
        {{sequence: [set: {{n: {0}}}, {{repeat: {{times: 5, do: {{sequence: [{{name: p, probe: {{script: RS}}}}, set: {{n: n + {0}}}]}}}}}}],
         out: {{n: int}}}}
    """
    trees = [bench.build(body.format(step)) for step in (1, 100)]
    runners = [bench.runner(tree, clock=VirtualClock(), watchers=[]) for tree in trees]
    while any(tree.root.status is not Status.SUCCESS for tree in trees):
        for runner in runners:
            runner.ticker.tick(runner.tree.root)
    assert [tree.outputs["n"][1].value for tree in trees] == [6, 600]


WAITING = """\
format: stretch-tree/1
tick: 1 ms
trees:
  main:
    out: {total: Time, when: Time}
    sequence:
      - until: {that: task.time >= 20 ms, max: 1000, do: {set: {when: task.time}}}
      - set: {total: task.time}
"""


def test_a_run_on_the_real_clock_replays_alike_however_late_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "tree.yaml").write_text(WAITING, encoding="utf-8")
    monkeypatch.setattr(execute, "VirtualClock", Sleepy)
    result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
    assert (result.status, result.overruns > 0) == ("SUCCESS", True)
    assert '"type":"overrun"' in (tmp_path / "record" / "events.jsonl").read_text("utf-8")
    again = replay(tmp_path / "record")
    assert again.identical, again.first_difference


def test_a_replay_ticks_at_every_recorded_time_also_after_one_that_was_late(bench: Any) -> None:
    times = [0.74, 0.81, 0.84, 0.89, 0.97, 0.99]
    notes = bench.run("probe: {script: R}", clock=ReplayClock(times), period=0.05)
    assert (notes.status, notes.ticks) == ("INTERRUPTED", len(times))


class Sleepy(VirtualClock):
    """A clock that is late by more and more, as a busy machine's."""

    def __init__(self) -> None:
        super().__init__()
        self._now = 0.7
        self.asked = 0

    def now(self) -> float:
        self.asked += 1
        self._now += 3e-4 * (self.asked % 7)
        return self._now


CELL = """\
format: stretch-cell/1
devices:
  arm: {type: Arm, use: simulated, height: 70 mm}
  gripper: {type: Gripper, use: simulated}
  camera: {type: DepthCamera, use: simulated}
limits: {force: 0.8 N, depth: 15 mm, contact: {below: 100 mm, speed: 12 mm/s}}
"""
#: nodes that go by the limits of the cell where those are tighter than their ports
BOUNDED = {
    "travel": "move_over: {x: 20 mm, y: 0 mm}",
    "press_gently": (
        "sequence: [approach: {max_travel: 60 mm, readings: 2, average: 2, contact_height: $h0, max_force: 0.7 N}, "
        "press_gently: {depth: 12 mm}]"
    ),
}


@pytest.mark.parametrize("body", BOUNDED.values(), ids=BOUNDED)
def test_a_replay_knows_the_limits_of_the_cell(tmp_path: Path, body: str) -> None:
    (tmp_path / "cell.yaml").write_text(CELL)
    (tmp_path / "tree.yaml").write_text(
        "format: stretch-tree/1\ndevices: {arm: Arm, camera: DepthCamera, gripper: Gripper}\n"
        f"trees: {{main: {{keys: {{h0: Length}}, {body}}}}}\n"
    )
    made = run(tmp_path / "tree.yaml", cell=tmp_path / "cell.yaml", scene="calibration_sphere", out=tmp_path / "record")
    assert made.status == "SUCCESS", made.reason
    assert replay(tmp_path / "record").identical
