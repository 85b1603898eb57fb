"""Everything falls silent at once: all stand-ins, while a run goes; and a driver's process, whose run is killed meanwhile."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from album import Album, album, enlisted
from lab import lab_cell
from waiting import eventually
from wired_run import CAMERA, LAB, TREE, WATCHED, Followed, problems, steps, under_way
from wired_servers import Servers

from stretch_bt import run

#: how long a run may go on after the last word of its devices, s
WITHIN = 1.0
#: a machine may be busy for a moment: so often it may try
TRIES = 3


@pytest.fixture(scope="module")
def servers():
    """Stand-ins in a process of their own, and what their camera sees ready."""
    album(lambda: 0.0, 50).frame()  # for the first picture code is compiled
    with enlisted(), Servers() as made:
        Album.hand = made.place.get
        yield made
        Album.hand = None


def freeze(servers, followed, phase, over, frozen):
    """Stop the stand-ins as soon as a node has something moving."""
    while not (over.is_set() or (phase in followed.running and under_way(servers, phase))):
        time.sleep(0.01)
    if not over.is_set():
        servers.freeze()
        frozen.append(time.monotonic())


def write(folder, servers, host, phase, camera):
    """Write tree and cell of a run, and begin the stand-ins that it reaches."""
    (folder / "tree.yaml").write_text(TREE.replace("STEPS", steps(phase)).replace("WATCHED", WATCHED[camera]))
    text = lab_cell(host, {**LAB, "camera": {}}) if camera else lab_cell(host, LAB) + CAMERA
    (folder / "wired.yaml").write_text(text)
    servers.ask(do="start", names=["ur", "robotiq", "ati", *(["album"] if camera else [])], host=host)


def silenced(folder, servers, host, phase, camera):
    """Do a run whose devices all fall silent in a phase; return how long it took to be over, s, and what was not as it should be."""
    folder.mkdir()
    write(folder, servers, host, phase, camera)
    frozen, over, followed = [], threading.Event(), Followed()
    harm = threading.Thread(target=freeze, args=(servers, followed, phase, over, frozen))
    harm.start()
    try:
        result = run(folder / "tree.yaml", cell=folder / "wired.yaml", out=folder / "record", watch=followed.watch)
    finally:
        over.set()
        harm.join()
        servers.thaw()
    assert frozen, f"it ended before: {result.status}: {result.reason}"
    found = list(problems(result, folder / "record", servers, ("stand-ins", "freeze")))
    servers.ask(do="stop")
    print(f"{phase}: over after {followed.over - frozen[0]:.3f} s, {result.reason}")  # noqa: T201
    return followed.over - frozen[0], found


@pytest.mark.parametrize(
    ("phase", "camera"),
    [
        ("approach", True),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("set_stretch", False),
                ("approach", False),
                ("roll", False),
                ("roll", True),
                ("set_stretch", True),
            )
        ),
    ],
)
def test_all_devices_fall_silent_and_the_run_ends_with_the_hand_at_rest(
    request, servers, own_hosts, tmp_path, phase, camera
):
    if camera:
        request.getfixturevalue("librealsense")
    took = []
    while not took or (took[-1] > WITHIN and len(took) < TRIES):
        seconds, found = silenced(tmp_path / str(len(took)), servers, next(own_hosts), phase, camera)
        assert found == []
        took.append(seconds)
    assert min(took) < WITHIN, took


#: a run in a process of its own; its tests' folder has the camera that is asked directly
RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import album
from stretch_bt import run
with album.enlisted():
    run(sys.argv[2] + "/tree.yaml", cell=sys.argv[2] + "/wired.yaml", out=sys.argv[2] + "/record")
"""


def state_of(pid):
    """Return the letter of a process' state; none where it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def children_of(pid):
    """Return the processes that a process began."""
    found = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for file in found for child in file.read_text().split()]


def send(number, processes):
    """Send a signal to processes, some of which may be gone."""
    for pid in processes:
        with suppress(ProcessLookupError):
            os.kill(pid, number)


@pytest.mark.parametrize(
    ("camera", "phase"), [(False, "set_stretch"), pytest.param(True, "approach", marks=pytest.mark.slow)]
)
def test_a_driver_that_is_stopped_when_its_run_is_killed_is_not_left(
    request, servers, own_hosts, tmp_path, camera, phase
):
    if camera:
        request.getfixturevalue("librealsense")
    write(tmp_path, servers, next(own_hosts), phase, camera)
    process, drivers = subprocess.Popen([sys.executable, "-c", RUN, Path(__file__).parent, tmp_path]), []
    try:
        eventually(lambda: under_way(servers, phase))
        drivers += children_of(process.pid)
        assert len(drivers) == 1 + camera
        send(signal.SIGSTOP, drivers)
        eventually(lambda: all(state_of(pid) == "T" for pid in drivers))
        process.kill()
        process.wait()
        eventually(lambda: all(state_of(pid) in ("", "Z") for pid in drivers))
        eventually(lambda: not servers.state("ur")["moving"])
    finally:
        send(signal.SIGKILL, [process.pid, *drivers])
        process.wait()
        servers.ask(do="stop")
