"""An exception in a thread of own code is in the result, with its last own line; the exit code stays the task's."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

LONG = 60
TREE = "format: stretch-tree/1\nimports: {own: own}\ntrees: {main: {sequence: [starts: {}]}}\n"
OWN = '''\
import os, threading
from stretch_bt import Behavior, Status, node

def break_it():
    raise ValueError(threading.current_thread().name)

def start(stage):
    if stage in os.environ["STAGES"].split():
        thread = threading.Thread(target=break_it, name=stage)
        thread.start()
        thread.join()

start("import")

@node
class Starts(Behavior):
    """Start a thread."""

    def update(self):
        start("update")
        return Status.SUCCESS
'''


@pytest.fixture
def called(tmp_path):
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "own.py").write_text(OWN)

    def call(stages, *words):
        line = [sys.executable, "-m", "stretch_bt", *words]
        env = {**os.environ, "STAGES": stages}
        return subprocess.run(line, cwd=tmp_path, env=env, capture_output=True, timeout=LONG, text=True)

    return call


def test_a_thread_that_breaks_is_in_the_result_and_leaves_the_exit_code(called):
    ended = called("import update", "run", "tree.yaml", "--json", "--quiet")
    found = json.loads(ended.stdout)
    assert (ended.returncode, found["status"]) == (0, "SUCCESS")
    assert found["errors"] == [
        f"thread '{stage}' broke (ValueError: {stage}) at own.py:5 in break_it" for stage in ("import", "update")
    ]
    for stage, broken in zip(("import", "update"), found["broken"], strict=True):
        assert broken["at"] == "own.py:5 in break_it"
        assert f"ValueError: {stage}" in broken["traceback"]
    assert json.loads((Path(found["record"]) / "result.json").read_text())["errors"] == found["errors"]
    assert "Traceback" not in ended.stderr


def test_every_frame_of_a_thread_is_shown_where_that_is_asked(called):
    assert "Traceback" in called("update", "run", "tree.yaml", "--quiet", "--traceback").stdout


def test_where_nothing_runs_a_thread_that_breaks_is_one_line_on_standard_error(called):
    ended = called("import", "check", "tree.yaml")
    assert ended.returncode == 0
    assert ended.stderr == "thread 'import' broke (ValueError: import) at own.py:5 in break_it\n"
