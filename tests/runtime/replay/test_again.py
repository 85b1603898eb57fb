"""What a replay says of a file that is wrong."""

import os
import signal
import sys

import pytest

from stretch_bt.errors import RecordError
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
