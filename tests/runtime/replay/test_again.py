"""What a replay says of a file that is wrong."""

import os
import sys

import pytest

from stretch_bt.errors import RecordError
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import run

TREE = """\
format: stretch-tree/1
imports: {stands_beside: stands_beside}
trees: {main: {marks: {}}}
"""
NODE = '''\
from stretch_bt import Behavior, Status, node

@node
class Marks(Behavior):
    """Do nothing."""

    def update(self):
        return Status.SUCCESS
'''


def test_a_finding_names_the_file_of_the_record_that_holds_the_text(tmp_path):
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "stands_beside.py").write_text(NODE)
    run(tmp_path / "tree.yaml", out=tmp_path / "record")
    del sys.modules["stands_beside"]  # as in another process
    with pytest.raises(RecordError) as refused:
        replay(tmp_path / "record")
    found = refused.value.diagnostics[0]
    assert found.file == os.fspath(tmp_path / "record/run.json")
    assert "in its text of tree.yaml, line 2: " in found.message
