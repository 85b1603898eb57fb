"""Every fault of arm, gripper, force sensor and camera in every phase of a task over their wires: see `wired_run.py`, which does the runs."""

import json
import os
import queue
import select
import statistics
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from lateness import Lateness

from stretch_bt.hardware.emulators.registry import stand_in_class

PROGRAM = Path(__file__).with_name("wired_run.py")
PHASES = ("approach", "press", "roll", "retract", "set_stretch")
#: faults that end no run, or no run in which their device has no command to move
HARMLESS = {
    *(("ur", fault) for fault in ("registers", "local", "loss", "wall")),
    *(("robotiq", fault) for fault in ("object", "unit", "late", "deaf")),
    *(("ati", fault) for fault in ("loss", "reorder", "repeat", "short", "slow", "drift", "wild")),
    *(("realsense", fault) for fault in ("reorder", "exchange")),
}
#: seen only while the fingers move
MOVING = {("robotiq", "stall")}
#: each takes half of a core; one more is begun where that is idle for a moment, s, and for so many cases:
#: to begin it takes as long as two of them
AT_ONCE, ROOM, MOMENT, EACH = os.cpu_count() or 1, 0.5, 0.5, 10
LONGEST = 100.0
#: so often a case is tried at most, where the machine was late
AGAIN = 4
#: a run ends so soon after its fault, s of the controller's clock
WITHIN = 1.0
#: and where it takes longer to see: an arm at a twentieth of its speed, fingers that stand, a clock that goes on beside the frames,
#: records that are late before their period is known
LATER = {("ur", "slider"): 2.0, ("robotiq", "stall"): 2.0, ("camera", "clock"): 2.0, ("ati", "late"): 2.0}


def faults(*devices):
    """Return every fault of stand-ins that ends a run."""
    named = [(device, fault) for device in devices for fault in stand_in_class(device).FAULTS]
    return [which for which in named if which not in HARMLESS]


def cases(phase):
    """Return the faults of a phase; while only the fingers move, the gripper's alone."""
    for device, fault in [*faults("ur", "robotiq", "ati"), ("driver", "kill"), ("driver", "hang")]:
        if device == "robotiq" if phase == "set_stretch" else (device, fault) not in MOVING:
            yield {"phase": phase, "device": device, "fault": fault}


def cases_of_camera(phase):
    """Return what the camera can do in a phase; a strip that is torn is as bad as half of the image."""
    for device, fault in [*faults("realsense"), ("camera driver", "kill"), ("camera driver", "hang")]:
        yield {"phase": phase, "device": device.replace("realsense", "camera"), "fault": fault}
    yield {"phase": phase, "device": "camera", "fault": "torn", "parameters": {"part": 0.3}}


def chosen(kind):
    """Return the cases of the default run: one fault of each device in one phase; with the device alone each is tested beside this."""
    found, every = {}, {phase: list(kind(phase)) for phase in PHASES}
    for phase, asked in every.items():
        for case in asked:
            found.setdefault((case["device"], case["fault"]), []).append((phase, case))
    devices = sorted({device for device, _ in found if "driver" not in device})
    for k, device in enumerate(devices):
        cases = min((which, cases) for which, cases in found.items() if which[0] == device)[1]
        yield cases[k % len(cases)][1]


@pytest.fixture(scope="module")
def done():
    """Do runs in some processes at once, as many as the cores have room for, and return what came of each; the processes are kept."""
    idle = queue.Queue()

    def do(asked):
        waiting, rows = queue.Queue(), []
        for case in asked:
            waiting.put(case)
        room, at_once = Room(), min(AT_ONCE, 1 + len(asked) // EACH)
        keepers = [threading.Thread(target=keep, args=(waiting, rows, idle, room)) for _ in range(at_once)]
        for keeper in keepers:
            keeper.start()
        for keeper in keepers:
            keeper.join()
        return rows

    yield do
    while not idle.empty():
        idle.get().communicate()


class Room:
    """Lets a run begin where no other goes on, or where the machine has room for one more."""

    def __init__(self):
        self.going, self.asking = [], threading.Lock()

    def __enter__(self):
        with self.asking:
            while self.going and idle_cores(MOMENT) < ROOM:
                pass
            self.going.append(None)

    def __exit__(self, *_):
        self.going.pop()


def idle_cores(seconds):
    """Return how many cores nobody used for some time, s."""
    before = idle_time()
    time.sleep(seconds)
    return (idle_time() - before) / seconds


def idle_time():
    """Return for how long cores were idle since the machine began, s, of all together."""
    return int(Path("/proc/stat").read_text().split()[4]) / os.sysconf("SC_CLK_TCK")


def keep(waiting, rows, idle, room):
    """Hand cases to a process, one by one; one that crashes or hangs is a problem of its case, and another is begun."""
    process, lateness = None, Lateness()
    while (case := taken(waiting)) is not None:
        process = process or taken(idle) or begun()
        for _ in range(AGAIN):
            with room:
                lateness.begin()
                process.stdin.write(json.dumps(case) + "\n")
                process.stdin.flush()
                ready, _, _ = select.select([process.stdout], [], [], LONGEST)
                line = process.stdout.readline() if ready else ""
            if not (line and missed(json.loads(line)) and lateness.was_late()):
                break
        if line:
            rows.append(json.loads(line))
            continue
        rows.append({**case, "took": None, "problems": ["it crashed" if ready else "it hangs"]})
        process.kill()
        process.communicate()
        process = None
    if process is not None:
        idle.put(process)


def taken(waiting):
    """Return what waits first, or None."""
    with suppress(queue.Empty):
        return waiting.get_nowait()


def begun():
    return subprocess.Popen([sys.executable, PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def missed(row):
    """Return whether a deadline was missed, or the run ended before its fault came; anything else that is wrong is never tried again."""
    unbegun = all(text.startswith("it ended before the fault") for text in row["problems"])
    return bool(told([row])) and unbegun


def print_times(rows):
    """Print how long each fault took to the end of its run."""
    for device, fault in dict.fromkeys((row["device"], row["fault"]) for row in rows):
        took = [
            row["took"] for row in rows if (row["device"], row["fault"]) == (device, fault) and row["took"] is not None
        ]
        if took:
            times = f"{statistics.median(took):6.3f} s, at most {max(took):6.3f} s"
            print(f"{device:14s}{fault:16s}{len(took):4d} runs, {times}")  # noqa: T201


def told(rows):
    """Return what was not as it should be."""
    late = [
        (*which(row), f"took {row['took']:.2f} s")
        for row in rows
        if (row["took"] or 0.0) > LATER.get((row["device"], row["fault"]), WITHIN)
    ]
    return late + [(*which(row), row["problems"]) for row in rows if row["problems"]]


def which(row):
    return row["phase"], row["device"], row["fault"]


def test_there_are_at_least_thirty_faults():
    assert all(len(list(cases(phase))) >= 30 for phase in PHASES if phase != "set_stretch")


@pytest.mark.parametrize("kind", [cases, cases_of_camera])
def test_every_fault_ends_the_run_and_nothing_moves_after_it(request, done, kind):
    if kind is cases_of_camera:
        request.getfixturevalue("librealsense")
    asked = list(chosen(kind))
    rows = done(asked)
    print_times(rows)
    assert told(rows) == []
    assert len(rows) == len(asked)


@pytest.mark.slow
@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("kind", [cases, cases_of_camera])
def test_every_fault_does_so_in_every_phase_twenty_times(request, done, phase, kind):
    if kind is cases_of_camera:
        request.getfixturevalue("librealsense")
    rows = done([case for _ in range(20) for case in kind(phase)])
    print_times(rows)
    assert told(rows) == []
