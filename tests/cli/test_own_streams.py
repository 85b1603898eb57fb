"""Own code that takes away streams, hooks or file descriptors takes neither the JSON nor the exit code of a run."""

import json
import os
import subprocess
import sys

import pytest

LONG = 60
TREE = "format: stretch-tree/1\nimports: {own: own}\ntrees: {main: {sequence: [does: {}]}}\n"
OWN = '''\
import os, resource, sys
from stretch_bt import Behavior, Status, node

@node
class Does(Behavior):
    """Do what a test asks for."""

    def update(self):
        exec(os.environ["IN_TICK"])
        return Status.SUCCESS
'''


TAKEN = [
    "sys.stderr = None",
    "sys.stdout = sys.stderr = None",
    "sys.excepthook = sys.unraisablehook = None",
    "os.closerange(3, 256)",
    "resource.setrlimit(resource.RLIMIT_NOFILE, (3, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))",
]


@pytest.mark.parametrize("does", ["; ".join(TAKEN), *(pytest.param(one, marks=pytest.mark.slow) for one in TAKEN)])
def test_what_own_code_takes_away_changes_nothing_of_a_run(tmp_path, does):
    (tmp_path / "tree.yaml").write_text(TREE)
    (tmp_path / "own.py").write_text(OWN)
    line = [sys.executable, "-m", "stretch_bt", "run", "tree.yaml", "--json"]
    ended = subprocess.run(
        line, cwd=tmp_path, env={**os.environ, "IN_TICK": does}, capture_output=True, timeout=LONG, text=True
    )
    assert (json.loads(ended.stdout)["status"], ended.returncode) == ("SUCCESS", 0), ended.stderr
    assert "Traceback" not in ended.stderr
