"""Runs over the wires of arm, gripper, force sensor and camera, each ended by one fault while one node moves something; a program of its own.

It reads one JSON object a line, `{"phase": ..., "device": ..., "fault": ...}` and where they are not those below `parameters`, does the
run, and prints one JSON object: how long the run took to be over, s of the controller's clock, with which status and reason, and
everything that was not as it should be.
"""

import faulthandler
import itertools
import json
import os
import signal
import sys
import tempfile
import threading
import time
import traceback
import warnings
from pathlib import Path

from album import Album, album, enlisted
from lab import lab_cell
from wired_servers import Servers

from stretch_bt import run
from stretch_bt.runtime.onlooker import Onlooker
from stretch_bt.runtime.replay import replay

LAB = {"arm": {"watchdog": "2.5 Hz", "lost_after": "400 ms"}, "gripper": {}, "force_sensor": {}}
#: where faults are not the camera's it is asked directly, which is quicker
CAMERA = "  camera: {type: DepthCamera, use: album, rate: 50 Hz}\n"
TREE = """\
format: stretch-tree/1
tick: 20 ms
devices: {arm: Arm, gripper: Gripper, force_sensor: ForceSensor, camera: DepthCamera}
keys: {frame: DepthFrame}
trees:
  main:
    guard: {that: "arm.force < 15 N and force_sensor.force < 15 N and gripper.opening < 1 m", name: watched}
    parallel:
      policy: success_on_one
      children:
        - sequence: [STEPS]
        - WATCHED
"""
#: a camera is watched by who looks at it; the others by the guard
WATCHED = {True: "repeat: {times: 1000, do: {capture: {frame: $frame}}}", False: "wait: {duration: 60 s}"}
#: inputs of each node where the fault comes in it, and where it only leads there
STEPS = {
    "set_stretch": ("{stretch: 30 mm, speed: 20 mm/s}", None),
    "approach": ("{speed: 5 mm/s}", "{speed: 50 mm/s, readings: 2, average: 1}"),
    "press": ("{depth: 12 mm, speed: 5 mm/s}", "{depth: 4 mm, speed: 50 mm/s}"),
    "roll": ("{radius: 15 mm, depth: 4 mm, laps: 3}", "{radius: 4 mm, depth: 4 mm, speed: 60 mm/s}"),
    "retract": ("{clearance: 50 mm, speed: 20 mm/s}", None),
}
#: where a device is looked at late, the run has not ended meanwhile
LATER = "{wait: {duration: 10 s}}"
RECORD = {"run.json", "events.jsonl", "record.mcap", "result.json", "report.html"}
LIMIT = 30.0
PARAMETERS = {
    ("ur", "slow"): {"rate": 1.0},
    ("ur", "late"): {"delay": 1.0},
    ("ur", "garbage"): {"bytes": 300},
    ("ur", "load"): {
        "fz": 60.0
    },  # past what a single sample may show, so that the guard of the tree does not see it first
    ("ur", "slider"): {"fraction": 0.05},
    ("ati", "load"): {"fz": 20.0},
    ("ati", "late"): {"delay": 0.4},
    ("robotiq", "slow"): {"delay": 0.6},
    ("robotiq", "wild"): {"part": 1.0},
    ("robotiq", "garbage"): {"bytes": 400},
    ("camera", "slow"): {"rate": 0.5},
    ("camera", "late"): {"delay": 2.0},
    ("camera", "loss"): {"part": 1.0},
}
#: modules of the processes of drivers that are ended
DRIVERS = {"driver": "stretch_bt.hardware.ur.process", "camera driver": "stretch_bt.hardware.realsense.process"}
#: what ends a run otherwise than as a fault: the tree's own guard
STATED = {("ati", "load"): "FAILURE"}
#: stand-ins by another name than the device's
BEHIND = {"camera": "album"}
#: a gripper that cannot be reached goes on to where it was last sent
UNTOLD = {("robotiq", fault) for fault in ("drop", "freeze", "slow", "corrupt", "truncate", "garbage", "crc", "refuse")}
#: how long it may take after a run to close its devices, one of which may hang, and to write the report, s
CLOSED = 5.0
#: after which a case is taken to hang, s
HANGS = 60.0
#: how fast the arm goes, m/s, where a phase is taken for under way
UNDER_WAY = 0.004


class Followed(Onlooker):
    """Knows which nodes run, and when the run was over: after that, devices are closed and the report is written."""

    def __init__(self):
        self.running = set()
        self.over = 0.0

    def status(self, path, status, reason=""):
        name = path.rpartition("/")[2]
        (self.running.add if status == "RUNNING" else self.running.discard)(name)

    def note(self, kind, **fields):
        if kind == "stop":
            self.over = time.monotonic()

    def watch(self, runner):
        runner.watchers.append(self)


def steps(phase):
    """Return the sequence of nodes that leads to one, at which the fault comes."""
    if phase == "set_stretch":
        return f"set_stretch: {STEPS[phase][0]}, {LATER}"
    names = [name for name in STEPS if name != "set_stretch"]
    before = names[: names.index(phase)]
    led = [f"{{{name}: {STEPS[name][1]}}}" for name in before]
    return ", ".join([*led, f"{{{phase}: {STEPS[phase][0]}}}", LATER])


def trial(phase, device, fault, servers, host, parameters=None):
    """Do a run that is ended by its fault, and return what came of it."""
    which, parameters = (device, fault), parameters or PARAMETERS.get((device, fault))
    wired = device.startswith("camera")
    names = ["ur", "robotiq", "ati", *(["album"] if wired else [])]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "tree.yaml").write_text(TREE.replace("STEPS", steps(phase)).replace("WATCHED", WATCHED[wired]))
        text = lab_cell(host, {**LAB, "camera": {}}) if wired else lab_cell(host, LAB) + CAMERA
        (folder / "wired.yaml").write_text(text)
        servers.ask(do="start", names=names, host=host)
        try:
            return ended_by(phase, (*which, parameters), servers, folder)
        finally:
            servers.ask(do="stop")


def ended_by(phase, which, servers, folder):
    """Do the run, and return how it ended and what was not as it should be."""
    injected, over, followed = [], threading.Event(), Followed()
    harm = threading.Thread(target=harmed, args=(servers, followed, phase, which, injected, over))
    harm.start()
    try:
        result = run(folder / "tree.yaml", cell=folder / "wired.yaml", out=folder / "record", watch=followed.watch)
    finally:
        ended = servers.state("ur")["time"]
        closed = time.monotonic() - followed.over
        over.set()
        harm.join()
    row = {"status": result.status, "reason": result.reason}
    if not injected:
        return {**row, "took": None, "problems": [f"it ended before the fault: {result.status}: {result.reason}"]}
    found = list(problems(result, folder / "record", servers, which[:2]))
    if closed > CLOSED:
        found.append(f"it took {closed:.2f} s to close the devices and write the record")
    return {**row, "took": ended - closed - injected[0], "problems": found}


def harmed(servers, followed, phase, which, injected, over):
    """Wait until a node has something moving, and do harm."""
    while not (over.is_set() or (phase in followed.running and under_way(servers, phase))):
        time.sleep(0.01)
    if over.is_set():
        return
    device, fault, parameters = which
    if device in DRIVERS:
        begun = servers.state("ur")
        os.kill(int(children(DRIVERS[device])[0]), signal.SIGKILL if fault == "kill" else signal.SIGSTOP)
    else:
        begun = servers.ask(do="inject", device=BEHIND.get(device, device), fault=fault, parameters=parameters)
    injected.append(begun["time"])


def under_way(servers, phase):
    state = servers.ask(do="state")
    return state["robotiq"]["opening"] > 0.060 if phase == "set_stretch" else state["ur"]["speed"] > UNDER_WAY


def problems(result, record, servers, which):
    """Yield what is not as it should be after a run that was ended by a fault."""
    if result.status != STATED.get(which, "FAULT") or not result.reason:
        yield f"it ended as {result.status}: {result.reason}"
    if left := children():
        yield f"processes are left: {left}"
    found = {path.name for path in record.iterdir()}
    if found != RECORD:
        yield f"the record has {sorted(found)}"
    elif json.loads((record / "result.json").read_text())["status"] != result.status:
        yield "the record does not say how the run ended"
    elif (again := replay(record).first_difference) is not None:
        yield f"its replay differs: {again}"
    state = eventually(lambda: not (now := servers.ask(do="state"))["ur"]["moving"] and now)
    if not state:
        yield "the arm goes on"
        return
    time.sleep(0.2)
    later = servers.ask(do="state")
    if later["ur"]["moved"] != state["ur"]["moved"]:
        yield "the arm moves again"
    if which not in UNTOLD and later["robotiq"]["opening"] != state["robotiq"]["opening"]:
        yield "the fingers move"


def eventually(ask):
    end = time.monotonic() + LIMIT
    while not (answer := ask()) and time.monotonic() < end:
        time.sleep(0.005)
    return answer


def children(module="stretch_bt.hardware"):
    """Return the processes of drivers that this one began and that are left."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split() if entry.name.isdigit() else []
            command = (entry / "cmdline").read_bytes() if fields and int(fields[1]) == os.getpid() else b""
        except OSError:  # it ended meanwhile
            continue
        if module.encode() in command:
            found.append(entry.name)
    return found


def main():
    warnings.simplefilter("error")
    broken = []
    threading.excepthook = lambda args: broken.append(f"a thread broke: {args.exc_type.__name__}: {args.exc_value}")
    album(lambda: 0.0, 50).frame()  # for the first picture code is compiled
    pid = os.getpid()
    hosts = (f"127.{101 + pid % 150}.{pid // 150 % 250}.{1 + k % 250}" for k in itertools.count())
    with enlisted(), Servers() as servers:
        Album.hand = servers.place.get
        for line in sys.stdin:
            asked = json.loads(line)
            faulthandler.dump_traceback_later(HANGS, exit=True)  # whoever waits hears where
            try:
                row = trial(**asked, servers=servers, host=next(hosts))
            except Exception:
                row = {"problems": [traceback.format_exc()], "took": None}
            faulthandler.cancel_dump_traceback_later()
            row["problems"] += broken
            broken.clear()
            print(json.dumps({**asked, **row}), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
