"""A disk that is full while an open cell records: everything is stopped, it is said once, and the cell goes on without its record."""

import errno
import json

import pytest
from py_trees.common import Status

import stretch_bt
from stretch_bt.errors import RecordError
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.runtime.record.spool import Spool

TASK = """\
format: stretch-tree/1
devices: {arm: Arm}
trees: {main: {sequence: [retract: {clearance: 50 mm, speed: 20 mm/s}], finally: [retract: {clearance: 10 mm, speed: 20 mm/s}]}}
"""


@pytest.fixture
def cell(tmp_path):
    opened = stretch_bt.open_cell(scene="calibration_sphere", out=tmp_path / "record")
    yield opened
    opened.close()


@pytest.fixture
def full(monkeypatch):
    """Fill the disk: from now on nothing more can be written of a record."""

    def write(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    return lambda: [monkeypatch.setattr(Spool, name, write) for name in ("write", "commit")]


def test_a_call_stops_everything_and_says_so(cell, full, tmp_path):
    motion = cell.gripper.move(0.08, speed=0.001, owner="by hand")
    cell.do("retract", clearance="1 mm")
    full()
    with pytest.raises(RecordError, match="cannot write the record: No space left on device"):
        cell.do("retract", clearance="20 mm")
    assert motion.poll() is MotionState.STOPPED
    cell.do("retract", clearance="1 mm")  # it is said once
    assert cell.do("measure_force").force.sd >= 0.0
    cell.close()
    assert json.loads((tmp_path / "record" / "result.json").read_text())


def test_a_subtree_stops_everything_and_its_finally_runs(cell, full, tmp_path):
    (tmp_path / "task.yaml").write_text(TASK)
    tree = stretch_bt.subtree(tmp_path / "task.yaml", cell)
    for _ in range(3):
        tree.tick_once()
    full()
    with pytest.raises(RecordError, match="No space left on device"):
        tree.tick_once()
    height = cell.arm.pose(1.0).value.height
    assert cell.pending_finally
    cell.settle()
    assert not cell.pending_finally
    assert cell.arm.pose(1.0).value.height == pytest.approx(height + 0.010, abs=2e-3)  # it brakes


def test_what_is_pending_runs_though_it_cannot_be_recorded(cell, full, tmp_path):
    (tmp_path / "task.yaml").write_text(TASK)
    tree = stretch_bt.subtree(tmp_path / "task.yaml", cell)
    tree.tick_once()
    tree.stop(Status.INVALID)
    height = cell.arm.pose(1.0).value.height
    full()
    with pytest.raises(RecordError, match="No space left on device"):
        cell.settle()
    assert cell.arm.pose(1.0).value.height == pytest.approx(height + 0.010, abs=2e-3)
