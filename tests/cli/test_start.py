"""How the command line ends: a signal at every instant of its last lines, and its output lost in every way."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from stretch_bt.cli import app, start
from stretch_bt.cli.stops import stops
from stretch_bt.runtime.signals import signals

LONG = 60
TREE = """\
format: stretch-tree/1
imports: {own: own}
trees: {main: {sequence: [{speaks: {}}]}}
"""
OWN = '''\
import os, sys
from stretch_bt import Behavior, Status, node

exec(os.environ.get("AT_IMPORT", ""))

@node
class Speaks(Behavior):
    """Do what a test asks for."""

    def update(self):
        exec(os.environ.get("IN_TICK", ""))
        return Status.SUCCESS
'''


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A tree with a node of its own, in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("tree.yaml").write_text(TREE)
    Path("own.py").write_text(OWN)


def in_shell(words, **env):
    """Run a command in a shell, which sends its outputs somewhere."""
    line = f"{sys.executable} -m stretch_bt {words}"
    return subprocess.run(["/bin/bash", "-c", line], capture_output=True, env={**os.environ, **env}, timeout=LONG)


def ended_with(end, count):
    """Carry out a command that ends with an exception, under a signal at the count-th instant from there on.

    An instant is one at which the interpreter looks at signals: where a function begins, and where a built-in one ends.
    """
    seen = 0

    def profile(frame, event, _):
        nonlocal seen
        if event in ("call", "c_return") and frame.f_code.co_filename in (start.__file__, stops_file):
            seen += 1
            if seen == count:
                os.kill(os.getpid(), signal.SIGINT)

    def carry_out():
        stops.way = "raise"
        if end is None:
            return
        sys.setprofile(profile)
        raise end

    stops_file = sys.modules[type(stops).__module__].__file__
    with pytest.MonkeyPatch.context() as patch, signals(stops):
        patch.setattr(app, "carry_out", carry_out)
        patch.setattr(sys, "argv", ["stretch-bt", "check", "--json"])
        stops.begin(process=False)
        try:
            code = start._code()
        finally:
            sys.setprofile(None)
    return code, seen


@pytest.mark.parametrize(
    ("end", "code"), [(KeyboardInterrupt("SIGINT"), 130), (SystemExit("told"), 1), (SystemExit(3), 3), (KeyError(1), 1)]
)
def test_a_signal_at_any_instant_of_the_end_changes_neither_code_nor_document(capfd, end, code):
    _, instants = ended_with(end, 0)
    capfd.readouterr()
    assert instants > 3
    for count in range(1, instants + 1):
        assert ended_with(end, count)[0] == code
        out, err = capfd.readouterr()
        assert {"error", "reason"} == json.loads(out).keys()
        assert "KeyboardInterrupt" not in err.replace("stopped by KeyboardInterrupt\n", "")


#: where the outputs go, what the node does -> the exit code, and whether standard error reports the loss
LOST = {
    (">/dev/full", ""): (0, True),
    (">/dev/full", "raise ValueError"): (1, True),
    (">/dev/full 2>/dev/full", ""): (0, False),
    (">&- 2>&-", "raise ValueError"): (1, False),
    ("> >(exec 0<&-; sleep 1)", ""): (0, False),
}


@pytest.mark.parametrize(
    ("case", "end"),
    [pytest.param(*row, marks=[pytest.mark.slow] * (k in (1, 2, 4))) for k, row in enumerate(LOST.items())],
)
def test_a_run_whose_output_is_lost_ends_with_the_code_of_its_task(own, case, end):
    (outputs, does), (code, is_told) = case, end
    ended = in_shell(f"run tree.yaml --json --out record {outputs}", IN_TICK=does)
    assert ended.returncode == code
    assert json.loads(Path("record/result.json").read_text())["status"] == ("ERROR" if code else "SUCCESS")
    assert (b"cannot write to standard output" in ended.stderr) == is_told
    assert b"Traceback" not in ended.stderr


CLOSES = ["sys.stdout.close(); sys.stderr.close(); sys.__stdout__.close()", "os.close(1)", "sys.stdout = None"]
PRINTS = "os.write(1, b'!'); os.system('echo !'); print('!'); print('!', file=sys.__stdout__, flush=True)"


@pytest.mark.parametrize(
    "does",
    ["; ".join([PRINTS, *CLOSES]), *(pytest.param(one, marks=pytest.mark.slow) for one in (PRINTS, *CLOSES))],
)
def test_nothing_that_a_node_does_to_standard_output_is_in_the_document(own, does):
    ended = in_shell("run tree.yaml --json", IN_TICK=does)
    assert (ended.returncode, json.loads(ended.stdout)["status"]) == (0, "SUCCESS")
    assert ended.stderr.count(b"!") == (4 if PRINTS in does else 0)


def test_what_a_module_prints_as_it_is_imported_is_not_in_the_document(own):
    ended = in_shell("check tree.yaml --json", AT_IMPORT="os.write(1, b'!'); print('?')")
    assert (ended.returncode, json.loads(ended.stdout)) == (0, [])
    assert b"!" in ended.stderr


@pytest.mark.parametrize("command", [pytest.param("run", marks=pytest.mark.slow), "check"])
def test_a_module_that_raises_what_a_signal_raises_is_told(own, command):
    ended = in_shell(f"{command} tree.yaml --json", AT_IMPORT="raise KeyboardInterrupt")
    assert ended.returncode == 130
    assert "stopped by KeyboardInterrupt" in json.loads(ended.stdout)["reason"]


def test_a_wrong_command_line_has_its_document():
    ended = in_shell("run --nosuch --json")
    assert ended.returncode == 2
    assert "--nosuch" in json.loads(ended.stdout)["reason"]
    assert b"Usage" in ended.stderr
