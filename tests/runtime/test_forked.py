"""A child that own code forks has no part in the run: it stops no device, runs no `finally`, and writes and prints nothing."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

LONG = 60
TREE = """\
format: stretch-tree/1
imports: {own: own}
trees:
  main:
    sequence: [forks: {}, marks: {where: ticked}]
    finally: {marks: {where: finished}}
"""
OWN = '''\
import os, sys, time
from stretch_bt import Behavior, In, Status, node

def fork(stage):
    if os.environ["STAGE"] == stage and os.fork() == 0:
        with open("child", "a") as file:
            file.write("x")
        exec(os.environ["CHILD"])
    else:
        while os.environ["STAGE"] == stage and not os.path.exists("child"):
            time.sleep(0.01)

fork("import")

@node
class Forks(Behavior):
    """Fork."""

    def prepare(self):
        fork("prepare")

    def initialise(self):
        fork("initialise")

    def update(self):
        fork("update")
        return Status.SUCCESS

    def terminate(self, new):
        fork("terminate")

@node
class Marks(Behavior):
    """Leave a mark."""
    where: In[str]

    def update(self):
        with open(self.where, "a") as file:
            file.write("x")
        return Status.SUCCESS
'''


STAGES, ENDS = ("import", "prepare", "initialise", "update", "terminate"), ("pass", "raise ValueError", "sys.exit(3)")


@pytest.mark.parametrize(
    ("stage", "child"),
    [
        pytest.param(stage, child, marks=[pytest.mark.slow] * (ENDS.index(child) != n % 2))
        for n, stage in enumerate(STAGES)
        for child in ENDS
    ],
)
def test_a_forked_child_leaves_the_run_to_the_process_that_began_it(tmp_path, stage, child):
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "own.py").write_text(OWN)
    line = [sys.executable, "-m", "stretch_bt", "run", "tree.yaml", "--json", "--out", "record"]
    env = {**os.environ, "STAGE": stage, "CHILD": child, "PYTHONWARNINGS": "ignore"}
    ended = subprocess.run(line, cwd=tmp_path, env=env, capture_output=True, timeout=LONG)
    found = json.loads(ended.stdout)
    assert (ended.returncode, found["status"], found["errors"]) == (0, "SUCCESS", [])
    assert [(tmp_path / name).read_text() for name in ("child", "ticked", "finished")] == ["x", "x", "x"]
    assert b"ValueError" not in ended.stderr

    assert json.loads(Path(tmp_path / "record/result.json").read_text())["status"] == "SUCCESS"
