"""What a replay says of a file that is wrong."""

import os
import signal
import sys
from typing import Any

import pytest

from stretch_bt.errors import RecordError
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import Poll
from stretch_bt.hardware.interfaces import MotionState, Reading
from stretch_bt.hardware.simulated.arm import SimulatedArm
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.replay.log import Log
from stretch_bt.runtime.task import run
from stretch_bt.tree import registry

TREE = """\
format: stretch-tree/1
imports: {stands_beside: stands_beside}
trees: {main: {out: {one: int}, sequence: [marks: {one}, check: one > 0]}}
"""
NODE = '''\
from stretch_bt import Behavior, Out, Status, node

@node
class Marks(Behavior):
    """Say one."""
    one: Out[int]

    def update(self):
        self.one = 1
        return Status.SUCCESS
'''


def test_a_finding_names_the_file_of_the_record_that_holds_the_text(tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "_nodes", dict(registry.load_all()))
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "stands_beside.py").write_text(NODE)
    run(tmp_path / "tree.yaml", out=tmp_path / "record")
    del sys.modules["stands_beside"], registry._nodes["marks"]  # as in another process
    with pytest.raises(RecordError) as refused:
        replay(tmp_path / "record")
    [found] = refused.value.diagnostics
    assert found.file == os.fspath(tmp_path / "record/run.json")
    assert "in its text of tree.yaml, line 2: " in found.message
    assert "add --trust" in found.hint
    (tmp_path / "stands_beside.py").unlink()
    with pytest.raises(RecordError) as refused:
        replay(tmp_path / "record", trust=True)
    assert f"put it back into {tmp_path}" in refused.value.diagnostics[0].hint


def test_mocks_stand_beside_an_imported_file_of_any_name(tmp_path):
    library = "format: stretch-tree/1\ntrees: {rest: {sequence: [wait: {duration: 1 s}]}}\n"
    (tmp_path / "mocks.yaml").write_text(library)
    tree = tmp_path / "tree.yaml"
    tree.write_text("format: stretch-tree/1\nimports: {a: mocks.yaml}\ntrees: {main: {sequence: [a.rest: {}]}}\n")
    mocks = {"format": "stretch-mocks/1", "tree": "tree.yaml", "mocks": [{"match": "**/wait", "after": "2 s"}]}
    result = run(tree, mocks=mocks, out=tmp_path / "record")
    assert result.task_seconds == pytest.approx(2.0, abs=0.1)
    assert replay(tmp_path / "record").identical


@pytest.mark.parametrize("ups", [1, 3, 4, 9])
def test_imports_that_go_up_replay_from_the_record_alone(tmp_path, ups):
    """Each file imports one of the same name in another folder."""
    home = tmp_path.joinpath("own", *"abcdefghi"[: ups - 1])
    home.mkdir(parents=True)
    library = tmp_path / "own.yaml"
    library.write_text("format: stretch-tree/1\ntrees: {rest: {sequence: [wait: {duration: 0.1 s}]}}\n")
    (home / "own.yaml").write_text(
        f"format: stretch-tree/1\nimports: {{lib: {'../' * ups}own.yaml}}\ntrees: {{main: {{sequence: [lib.rest]}}}}\n"
    )
    assert run(home / "own.yaml", out=tmp_path / "record").status == "SUCCESS"
    (home / "own.yaml").unlink()
    library.unlink()
    assert replay(tmp_path / "record").identical


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_replay_that_is_interrupted_says_so_and_compares_nothing(tmp_path, monkeypatch, name):
    """It ended as `differs`, at the tick to which it had come."""
    record = tmp_path / "record"
    tree = "{format: stretch-tree/1, trees: {main: {sequence: [wait: {duration: 2 s}]}}}"
    (tmp_path / "tree.yaml").write_text(tree)
    assert run(tmp_path / "tree.yaml", out=record).status == "SUCCESS"
    begin = Log.begin_tick

    def interrupted(log, tick, time):
        if tick == 5:
            signal.raise_signal(getattr(signal, name))
        begin(log, tick, time)

    monkeypatch.setattr(Log, "begin_tick", interrupted)
    with pytest.raises(KeyboardInterrupt, match=name):
        replay(record)
    monkeypatch.undo()
    assert replay(record).identical


def lost(*_: object) -> None:
    raise OSError("the cable is out")


def lost_on_its_way(arm: SimulatedArm, path: object, speed: float) -> Poll:
    begun = arm.cell.now()
    return lambda: MotionState.MOVING if arm.cell.now() < begun + 0.2 else lost()  # type: ignore[func-returns-value]


def faster(arm: SimulatedArm, path: list[Pose], speed: float, follow: Any = SimulatedArm.follow) -> Poll:
    return follow(arm, path, 40 * speed)


def pushed_later(arm: SimulatedArm) -> Reading[Wrench]:
    now = arm.cell.now()
    return Reading(Wrench((0.0, 0.0, 0.0 if now < 6.0 else 90.0)), now, now, round(1e3 * now))


def old_force(arm: SimulatedArm) -> Reading[Wrench]:
    then = arm.cell.now() - 0.2
    return Reading(Wrench((0.0, 0.0, 0.0)), then, then, round(1e3 * then))


#: faults of an arm that goes up: methods of its driver, and what each does instead
BROKEN = {
    "too fast for the cell": {"follow": faster},
    "lost as it is sent": {"follow": lost},
    "lost on its way": {"follow": lost_on_its_way},
    "lost, and not to be stopped": {"follow": lost_on_its_way, "stop": lost},
    "lost, and not to be stopped or closed": {"follow": lost_on_its_way, "stop": lost, "close": lost},
    "lost where its force is read": {"wrench": lost},
    "pushed where it stands": {"wrench": pushed_later},
}
GOES_UP = """\
format: stretch-tree/1
devices: {arm: Arm}
scene: water_balloon
trees:
  main:
    sequence: [retract: {clearance: 300 mm, speed: 100 mm/s}, wait: {duration: 3 s}, check: arm.force < 5 N]
    finally: [retract: {clearance: 10 mm}]
"""


@pytest.mark.parametrize("name", BROKEN)
def test_a_run_that_a_fault_ended_replays_as_the_same(tmp_path, monkeypatch, name):
    """A motion that the cell had halted was once stopped a second time, and faults of stopping and closing were missed."""
    (tmp_path / "tree.yaml").write_text(GOES_UP)
    for method, instead in BROKEN[name].items():
        monkeypatch.setattr(SimulatedArm, method, instead)
    result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
    monkeypatch.undo()
    assert result.status == "FAULT", result.reason
    found = replay(tmp_path / "record")
    assert found.identical, found.first_difference


NEARER = '''\
from stretch_bt import Behavior, Status, Uses, node
from stretch_bt.errors import BeyondLimits, StaleReading
from stretch_bt.hardware.interfaces import Arm, MotionState

@node
class Nearer(Behavior):
    """Go as far as is allowed, and look at a force that may be old meanwhile."""
    arm: Uses[Arm]

    def initialise(self):
        here = self.arm.pose(1.0).value
        for far in (1.5, 0.02):
            try:
                self.motion = self.arm.move(here.moved(z=far), speed=0.1, owner=self.path)
                break
            except BeyondLimits:
                pass
        try:
            self.arm.wrench(1e-9)
        except StaleReading:
            pass

    def update(self):
        return Status.SUCCESS if self.motion.poll() is MotionState.DONE else Status.RUNNING
'''


def test_refusals_and_old_readings_that_a_node_catches_are_repeated(tmp_path, monkeypatch):
    """A fault of a later reading was once taken for the command's, and a refusal for nothing where another command followed."""
    monkeypatch.setattr(registry, "_nodes", dict(registry.load_all()))
    (tmp_path / "goes_nearer.py").write_text(NEARER)
    tree = "format: stretch-tree/1\nimports: {own: goes_nearer}\ndevices: {arm: Arm}\nscene: water_balloon\n"
    (tmp_path / "tree.yaml").write_text(f"{tree}trees: {{main: {{sequence: [nearer]}}}}\n")
    with monkeypatch.context() as patched:
        patched.setattr(SimulatedArm, "wrench", old_force)
        result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
    assert result.status == "SUCCESS", result.reason
    found = replay(tmp_path / "record", trust=True)
    assert found.identical, found.first_difference
