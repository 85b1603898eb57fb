"""Runs over the wires of arm, gripper and force sensor, each ended by one fault while one node moves something; a program of its own.

It reads one JSON object a line, `{"phase": ..., "device": ..., "fault": ...}`, does the run, and prints one JSON object: how long the
run took to its end, with which status and reason, how often it was begun, and everything that was not as it should be.
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

from lab import lab_cell

from stretch_bt import run
from stretch_bt.errors import DeviceFault
from stretch_bt.frames import DepthFrame, Pose
from stretch_bt.hardware.driver import Bench
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.hand import Hand, HandGeometry
from stretch_bt.hardware.implementations import IMPLEMENTATIONS
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.simulated.camera import SimulatedCamera, _Options
from stretch_bt.hardware.simulated.twin import Twin
from stretch_bt.run.onlooker import Onlooker
from stretch_bt.simulation.camera.counts import counts
from stretch_bt.simulation.camera.sensor import Shot
from stretch_bt.simulation.scene import load_scene

LAB = {"arm": {"watchdog": "2.5 Hz", "lost_after": "400 ms"}, "gripper": {}, "force_sensor": {}}
CAMERA = "  camera: {type: DepthCamera, use: album, rate: 50 Hz}\n"
#: an object so high that the hand of the stand-in is soon there
SCENE = """\
format: stretch-scene/1
fidelity: hertz
object: {type: sphere, diameter: 20 mm, rigid: true, base: 175 mm}
conditions: {stretch: 0 mm, depth: 8 mm, hold: 1 s, speed: 0 mm/s, frames: 8, presses: 15, travel: 0 mm}
"""
TREE = """\
format: stretch-tree/1
tick: 20 ms
devices: {arm: Arm, gripper: Gripper, force_sensor: ForceSensor, camera: DepthCamera}
trees:
  main:
    guard: {that: "arm.force < 15 N and force_sensor.force < 15 N and gripper.opening < 1 m", name: watched}
    sequence: [STEPS]
"""
#: what each node is told where the fault comes in it, and where it only leads there
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
    ("ur", "load"): {"fz": 30.0},
    ("ur", "slider"): {"fraction": 0.05},
    ("ati", "load"): {"fz": 20.0},
    ("robotiq", "slow"): {"delay": 0.6},
    ("robotiq", "garbage"): {"bytes": 400},
}
#: what ends a run otherwise than as a fault: the tree's own guard
STATED = {("ati", "load"): "FAILURE"}
#: how often a run may be begun again that this machine was too busy for, so that it ended before its fault
AGAIN = 25
#: a gripper that cannot be reached goes on to where it was last sent
UNTOLD = {("robotiq", fault) for fault in ("drop", "freeze", "slow", "corrupt", "truncate", "garbage", "crc", "refuse")}
#: after which a case is taken to hang, s
HANGS = 200.0
#: how fast the arm goes, m/s, where a phase is taken for under way
UNDER_WAY = 0.004
#: pictures of one pose that differ by their noise
ALIKE = 16


class Album(SimulatedCamera):
    """Sees a twin of its own, pressed as deep as the hand of the stand-in is low; each picture is taken once, to a quarter of a millimetre."""

    class Options(_Options):
        use: str

    simulated = False
    stand_in = None
    _twin, _pictures = None, {}

    def __init__(self, name, options, bench):
        seen = type(bench)(bench.now, 0, bench.root, bench.hand, bench.limits)
        seen.__dict__["twin"] = type(self)._twin = type(self)._twin or twin()
        super().__init__(name, options, seen)

    def _expose(self, number):
        pose, time_ = self.stand_in.hand(), number / self.options.rate
        key = round(4e3 * pose.height) / 4e3, number % ALIKE
        if key not in self._pictures:
            there = pose.at_height(key[0])
            exposure = self._sensor.expose(Shot(time_, key[1], there, 0.0, self._twin.world.contact(there, 0.0)))
            self._pictures[key] = counts(exposure), exposure.unit
        raw, unit = self._pictures[key]
        frame = DepthFrame(raw, unit, self.intrinsics, time_, number, plane_distance=HandGeometry().plane_distance)
        return Reading(frame, time_, time_, number)


def twin():
    """The twin that is looked at; nothing moves in it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "high.yaml"
        path.write_text(SCENE)
        return Twin(load_scene(path), HandGeometry(), lambda: 0.0, 0)


class Followed(Onlooker):
    """Knows which nodes run."""

    def __init__(self):
        self.running = set()

    def status(self, path, status, reason=""):
        name = path.rpartition("/")[2]
        (self.running.add if status == "RUNNING" else self.running.discard)(name)

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


def trial(phase, device, fault, hosts):
    """Do a run until one was ended by its fault, and return what came of it."""
    unasked = []
    for k in range(AGAIN):
        with tempfile.TemporaryDirectory() as folder:
            row = attempt(phase, device, fault, next(hosts), Path(folder))
        if row["took"] is not None or row["problems"]:
            return {**row, "begun": k + 1, "unasked": unasked}
        unasked.append(row["reason"])
    return {**row, "begun": AGAIN, "unasked": unasked, "problems": ["it always ended before the fault"]}


def attempt(phase, device, fault, host, folder):
    (folder / "tree.yaml").write_text(TREE.replace("STEPS", steps(phase)))
    (folder / "wired.yaml").write_text(lab_cell(host, LAB) + CAMERA)
    injected, over, followed = [], threading.Event(), Followed()
    with serving(["ur", "robotiq", "ati"], Stage(), host=host, activated=True) as servers:
        behind = servers.stand_ins
        Album.stand_in = behind["ur"]
        harm = threading.Thread(target=harmed, args=(behind, followed, phase, (device, fault), injected, over))
        harm.start()
        try:
            result = run(folder / "tree.yaml", cell=folder / "wired.yaml", out=folder / "record", watch=followed.watch)
        except DeviceFault as fault:
            if injected:
                raise
            return {"reason": str(fault), "took": None, "problems": []}  # a busy machine did not open it in time
        finally:
            ended = time.monotonic()
            over.set()
            harm.join()
        row = {"status": result.status, "reason": result.reason, "took": None, "problems": []}
        if injected:
            row["took"] = ended - injected[0]
            row["problems"] = list(problems(result, folder / "record", behind, (device, fault)))
        return row


def harmed(behind, followed, phase, which, injected, over):
    """Wait until a node has something moving, and do harm."""
    while not (over.is_set() or (phase in followed.running and under_way(behind, phase))):
        time.sleep(0.005)
    if over.is_set():
        return
    device, fault = which
    if device == "driver":
        os.kill(int(children()[0]), signal.SIGKILL if fault == "kill" else signal.SIGSTOP)
    else:
        behind[device].inject(fault, PARAMETERS.get(which))
    injected.append(time.monotonic())


def under_way(behind, phase):
    if phase == "set_stretch":
        return behind["robotiq"].state()["opening"] > 0.060
    return behind["ur"].state()["speed"] > UNDER_WAY


def problems(result, record, behind, which):
    """Yield what is not as it should be after a run that was ended by a fault."""
    if result.status != STATED.get(which, "FAULT") or not result.reason:
        yield f"it ended as {result.status}: {result.reason}"
    if left := children():
        yield f"processes are left: {left}"
    found = {path.name for path in record.iterdir()}
    if found != RECORD:
        yield f"the record has {sorted(found)}"
    elif json.loads((record / "result.json").read_text())["status"] != result.status:
        yield "the record does not tell how the run ended"
    if not eventually(lambda: not behind["ur"].state()["moving"]):
        yield "the arm goes on"
    moved, opening = behind["ur"].state()["moved"], behind["robotiq"].state()["opening"]
    time.sleep(0.2)
    if behind["ur"].state()["moved"] != moved:
        yield "the arm moves again"
    if which not in UNTOLD and behind["robotiq"].state()["opening"] != opening:
        yield "the fingers move"


def eventually(ask):
    end = time.monotonic() + LIMIT
    while not (answer := ask()) and time.monotonic() < end:
        time.sleep(0.005)
    return answer


def children():
    """Return the processes of arms that this one began and that are left."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split() if entry.name.isdigit() else []
            command = (entry / "cmdline").read_bytes() if fields and int(fields[1]) == os.getpid() else b""
        except OSError:  # it ended meanwhile
            continue
        if b"stretch_bt.hardware.ur.process" in command:
            found.append(entry.name)
    return found


def warm_up():
    """Take the first pictures, for which code is compiled."""
    Album.stand_in = type("There", (), {"hand": lambda self: Pose((0.0, 0.0, 0.19))})()
    options = Album.Options(type="DepthCamera", use="album", rate="50 Hz")
    Album("camera", options, Bench(lambda: 0.0, 0, Path(), Hand(), Limits())).frame()


def main():
    warnings.simplefilter("error")
    broken = []
    threading.excepthook = lambda args: broken.append(f"a thread broke: {args.exc_type.__name__}: {args.exc_value}")
    IMPLEMENTATIONS["DepthCamera", "album"] = f"{__name__}:Album"
    warm_up()
    pid = os.getpid()
    hosts = (f"127.{101 + pid % 150}.{pid // 150 % 250}.{1 + k % 250}" for k in itertools.count())
    for line in sys.stdin:
        asked = json.loads(line)
        faulthandler.dump_traceback_later(HANGS, exit=True)  # whoever waits hears where
        try:
            row = trial(**asked, hosts=hosts)
        except Exception:
            row = {"problems": [traceback.format_exc()], "took": None}
        faulthandler.cancel_dump_traceback_later()
        row["problems"] += broken
        broken.clear()
        print(json.dumps({**asked, **row}), flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
