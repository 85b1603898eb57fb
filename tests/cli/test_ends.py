"""How a command ends when a signal comes, at whatever stage, and when nobody reads what it prints."""

import json
import os
import pty
import signal
import subprocess
import sys
import termios
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from stretch_bt.cli import stops as stops_module
from stretch_bt.cli.outlet import PATIENCE, ROOM, Outlet
from stretch_bt.cli.stops import Stops

COMMAND = [sys.executable, "-m", "stretch_bt"]
#: after which a process hangs, s
LONG = 60

TREE = """\
format: stretch-tree/1
imports: {own: own}
devices: {arm: Arm}
scene: ball.yaml
trees: {main: {sequence: [{speaks: {}}, {retract: {clearance: 20 mm}}]}}
"""
#: of which a press is known at once, and for which little has to be loaded
BALL = "format: stretch-scene/1\nobject: {type: sphere, diameter: 20 mm, stiffness: 2 N/mm}\nfidelity: hertz\n"
OWN = '''\
import os, signal, sys
from stretch_bt import Behavior, Status, node

STAGE = os.environ.get("STAGE", "")

def at(stage):
    if stage == STAGE:
        os.kill(os.getpid(), signal.SIGTERM)

@node
class Speaks(Behavior):
    """Print much, and come under a signal."""

    def update(self):
        print("x" * int(os.environ.get("WORDS", "0")))
        print("y" * int(os.environ.get("WORDS", "0")), file=sys.stderr)
        at("tick")
        return Status.SUCCESS

at("import")
'''


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A tree with a node of its own, in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("tree.yaml").write_text(TREE)
    Path("ball.yaml").write_text(BALL)
    Path("own.py").write_text(OWN)


@pytest.fixture
def full():
    """The end of a pipe that takes nothing more."""
    kept, given = os.pipe()
    os.set_blocking(given, False)
    for size in (4096, 1):
        with suppress(BlockingIOError):
            while True:
                os.write(given, b"x" * size)
    os.set_blocking(given, True)
    yield given
    os.close(kept)
    with suppress(OSError):
        os.close(given)


def called(*words, **options):
    return subprocess.run([*COMMAND, *words], stdin=subprocess.DEVNULL, timeout=LONG, **options)


@contextmanager
def started(*words, **options):
    """A command that goes on beside the test, and is ended with it."""
    with subprocess.Popen([*COMMAND, *words], stdin=subprocess.DEVNULL, **options) as run:
        try:
            yield run
        finally:
            run.kill()


def reported(run):
    """Wait until a run has written its report, which it does after its devices are closed."""
    began = time.monotonic()
    while not Path("record/report.html").exists():
        assert time.monotonic() - began < LONG
        assert run.poll() is None
        time.sleep(0.02)


def test_the_handler_stands_before_anything_heavy_is_imported():
    code = "import sys; before = {*sys.modules}; import stretch_bt.cli; print(*{*sys.modules} - before)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    long = {"numpy", "scipy", "numba", "cv2", "py_trees", "yaml", "typer", "click", "rich", "pydantic"}
    assert {*long, "json", "typing", "re"}.isdisjoint(loaded)


@pytest.mark.parametrize(
    "command", [("run", "tree.yaml"), pytest.param(("check", "tree.yaml"), marks=pytest.mark.slow)]
)
def test_a_signal_while_modules_are_imported_is_answered_with_the_json(own, cli, command):
    """That of a run has the fields of any other."""
    env = {**os.environ, "STAGE": "import"}
    ended = called(*command, "--json", env=env, capture_output=True)
    assert ended.returncode == 130
    found = json.loads(ended.stdout)
    assert "stopped by SIGTERM" in found["reason"]
    assert b"Traceback" not in ended.stderr
    assert not Path("runs").exists()
    if command[0] == "run":
        assert (found["status"], found["ticks"], found["record"]) == ("INTERRUPTED", 0, None)
        refused = json.loads(cli("run", "none.yaml", "--json")[1])
        Path("wait.yaml").write_text("format: stretch-tree/1\ntrees: {main: {sequence: [wait: {duration: 1 ms}]}}\n")
        code, run_, _ = cli("run", "wait.yaml", "--json")
        assert code == 0
        assert found.keys() == refused.keys() == {*json.loads(run_), "diagnostics"}


def test_a_signal_in_the_last_tick_is_in_the_result(own):
    Path("tree.yaml").write_text(TREE.replace(", {retract: {clearance: 20 mm}}", ""))
    ended = called("run", "tree.yaml", "--json", env={**os.environ, "STAGE": "tick"}, capture_output=True)
    found = json.loads(ended.stdout)
    assert (ended.returncode, found["status"]) == (130, "INTERRUPTED")
    assert "after the task had ended with SUCCESS" in found["reason"]


@pytest.mark.parametrize("nohup", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_signal_in_a_tick_ends_the_run_with_its_record_though_it_was_ignored_at_the_start(own, nohup):
    def ignore():
        if nohup:
            signal.signal(signal.SIGTERM, signal.SIG_IGN)

    env = {**os.environ, "STAGE": "tick"}
    ended = called("run", "tree.yaml", "--json", env=env, capture_output=True, preexec_fn=ignore)
    found = json.loads(ended.stdout)
    assert (ended.returncode, found["status"]) == (130, "INTERRUPTED")
    assert json.loads((Path(found["record"]) / "result.json").read_text())["status"] == "INTERRUPTED"


@pytest.mark.parametrize("options", [["--json"], pytest.param([], marks=pytest.mark.slow)])
def test_a_full_standard_error_stops_neither_ticks_nor_end(own, full, options):
    env = {**os.environ, "WORDS": str(3 * ROOM)}
    ended = called("run", "tree.yaml", *options, env=env, stdout=subprocess.PIPE, stderr=full)
    status = json.loads(ended.stdout)["status"] if options else ended.stdout.split()[0].decode()
    assert (ended.returncode, status) == (0, "SUCCESS")


@pytest.mark.slow
def test_a_signal_is_heard_behind_a_full_standard_error(own, full):
    env = {**os.environ, "WORDS": str(3 * ROOM), "STAGE": "tick"}
    ended = called("run", "tree.yaml", "--json", env=env, stdout=subprocess.PIPE, stderr=full)
    assert (ended.returncode, json.loads(ended.stdout)["status"]) == (130, "INTERRUPTED")


@pytest.mark.parametrize(
    "closed", [*(pytest.param(one, marks=pytest.mark.slow) for one in ("1>&-", "2>&-")), "0<&- 1>&- 2>&-"]
)
def test_closed_outputs_change_nothing_of_a_run(own, closed):
    line = f"exec {' '.join(COMMAND)} run tree.yaml --json --out record {closed}"
    ended = subprocess.run(line, shell=True, capture_output=True, timeout=LONG)
    assert ended.returncode == 0
    assert b"Traceback" not in ended.stderr
    assert json.loads(Path("record/result.json").read_text())["status"] == "SUCCESS"
    assert json.loads(Path("record/run.json").read_text())


@pytest.mark.parametrize("options", [["--json"], pytest.param([], marks=pytest.mark.slow)])
def test_a_reader_that_is_gone_changes_nothing_of_a_run(own, options):
    kept, given = os.pipe()
    os.close(kept)
    ended = called("run", "tree.yaml", *options, stdout=given, stderr=subprocess.PIPE)
    os.close(given)
    assert (ended.returncode, b"Traceback" in ended.stderr) == (0, False)


def test_a_result_that_is_lost_is_told():
    with Path("/dev/full").open("wb") as gone:
        ended = called("nodes", "--json", stdout=gone, stderr=subprocess.PIPE)
    assert (ended.returncode, ended.stderr) == (
        1,
        b"error: cannot write to standard output: No space left on device\n",
    )


def test_a_halted_terminal_holds_up_neither_the_run_nor_its_closing_and_gets_the_result_later(own):
    ours, theirs = pty.openpty()
    termios.tcflow(theirs, termios.TCOOFF)  # Ctrl-S
    with started("run", "tree.yaml", "--out", "record", stdout=theirs, stderr=theirs) as run:
        reported(run)
        termios.tcflow(theirs, termios.TCOON)  # Ctrl-Q
        read = b""
        while b"record: " not in read:
            read += os.read(ours, 4096)
        assert run.wait(LONG) == 0
    os.close(ours)
    os.close(theirs)
    assert b"SUCCESS" in read


def test_a_signal_ends_a_run_whose_result_nobody_takes(own, full):
    with started("run", "tree.yaml", "--out", "record", stdout=full, stderr=full) as run:
        reported(run)
        run.send_signal(signal.SIGINT)
        code = run.wait(LONG)
    status = json.loads(Path("record/result.json").read_text())["status"]
    # a record that is closed keeps how the task ended, though a signal came before the exit
    assert (status, code) in (("SUCCESS", 0), ("SUCCESS", 130), ("INTERRUPTED", 130))


@pytest.mark.parametrize("words", [[], ["--json"]])
def test_a_signal_in_a_tick_ends_a_run_whose_result_nobody_takes(own, full, words):
    """The run had taken it, and the end waited for a reader all the same."""
    env = {**os.environ, "STAGE": "tick"}
    ended = called("run", "tree.yaml", "--out", "record", *words, env=env, stdout=full, stderr=full)
    assert ended.returncode == 130
    assert json.loads(Path("record/result.json").read_text())["status"] == "INTERRUPTED"


def test_an_outlet_drops_pictures_and_keeps_results_in_their_order(full):
    kept, given = os.pipe()
    outlet = Outlet(given)
    outlet.write(b"first ")
    outlet.pictures = True
    for _ in range(4 * ROOM // 1000):
        outlet.write(b"p" * 1000)
    outlet.pictures = False
    outlet.write(b"last")
    read = bytearray()

    def take():
        while not read.endswith(b"last"):
            read.extend(os.read(kept, 4096))

    reader = threading.Thread(target=take)
    reader.start()
    outlet.drain(lambda: False)
    reader.join(LONG)
    os.close(kept)
    os.close(given)
    assert read.startswith(b"first ")
    assert ROOM // 2 < read.count(b"p") < 3 * ROOM, "a pipe and the queue"


@pytest.mark.parametrize(("picture", "stopped"), [(True, False), (False, True)])
def test_an_outlet_waits_for_no_reader_of_pictures_and_for_none_once_it_is_stopped(full, picture, stopped):
    outlet = Outlet(full)
    outlet.pictures = picture
    outlet.write(b"x")
    began = time.monotonic()
    outlet.drain(lambda: stopped)
    assert time.monotonic() - began >= PATIENCE


def test_an_outlet_waits_for_a_slow_reader_of_results():
    kept, given = os.pipe()
    outlet = Outlet(given)
    outlet.write(b"x" * (2 << 16))
    threading.Timer(2 * PATIENCE, lambda: os.set_blocking(kept, False)).start()
    ended = threading.Thread(target=outlet.drain, args=(lambda: False,))
    ended.start()
    ended.join(3 * PATIENCE)
    assert ended.is_alive()
    while ended.is_alive():
        with suppress(BlockingIOError):
            os.read(kept, 1 << 16)
    os.close(kept)
    os.close(given)


def test_what_a_signal_does_depends_on_the_stage(monkeypatch):
    ended = []
    monkeypatch.setattr(stops_module.os, "_exit", ended.append)
    monkeypatch.setattr(stops_module, "_give", lambda *_: None)
    stops = Stops()
    stops.begin(process=True)
    stops("SIGINT")
    assert ended == [130]
    stops.begin(process=False)
    with pytest.raises(KeyboardInterrupt):
        stops("SIGINT")
    stops.way = "raise"
    with pytest.raises(KeyboardInterrupt):
        stops("SIGTERM")
    stops.way = "note"
    stops("SIGHUP")
    assert (stops.way, stops.names) == ("note", ["SIGINT", "SIGTERM", "SIGHUP"])
