"""Single nodes of a characterisation, on scripted devices."""

from functools import partial

import pytest

from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.run.context import RunContext
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import Role, Status
from stretch_bt.tree.registry import lookup

TOUCHED = 0.060
SMALL = {"diameters": [0.02, 0.03], "stretches": [0.0, 0.01], "depths": [0.0, 0.002], "trials": 1}


def told(node):
    """Return what `next_state` told."""
    names = ("geometry", "diameter", "stretch", "depth", "trial", "new_indenter", "new_trial", "rows")
    return tuple(node.sinks[name].value for name in names)


class Sensor:
    """A force sensor that says what it is told, with the number of each reading; the last one stays."""

    def __init__(self, forces, numbers=None):
        self.forces, self.numbers, self.now, self.zeroed = list(forces), numbers, lambda: 0.0, 0
        self.read = -1

    def wrench(self, max_age):
        self.read += 1
        number = self.read if self.numbers is None else self.numbers[min(self.read, len(self.numbers) - 1)]
        force = self.forces[min(self.read, len(self.forces) - 1)]
        return Reading(Wrench(force if isinstance(force, tuple) else (0.0, 0.0, force)), self.now(), self.now(), number)

    def zero(self):
        self.zeroed += 1


class Bench:
    """A run of single nodes: one context, a clock, and devices that stay from node to node."""

    def __init__(self, folder, **devices):
        self.context = RunContext()
        self.context.folder = folder
        self.context.about = {"scene": "calibration_sphere", "seed": 4, "versions": {}}
        self.context.hand.contact_height = TOUCHED
        for device in devices.values():
            device.now = lambda: self.context.now
        self.context.devices = {
            "arm": ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, TOUCHED))}),
            "gripper": ScriptedDevice("Gripper", {"opening": 0.065}),
            **devices,
        }

    def stand(self, height, rotation=(0.0, 0.0, 0.0)):
        self.context.devices["arm"] = ScriptedDevice("Arm", {"pose": Pose((0.0, 0.0, height), rotation)})

    def node(self, name, **inputs):
        info = lookup(name)
        node = info.cls(f"main/{name}")
        node.context = self.context
        node.device_names = {p.name: p.name for p in info.of(Role.DEVICE) if p.name in self.context.devices}
        for port in info.of(Role.INPUT):
            node.wiring[port.name] = partial(inputs.get, port.name, port.default)
        return node

    def tick(self, node, times=1):
        for _ in range(times):
            for _ in node.tick():
                pass
            self.context.now += 0.05
        return node.status

    def run(self, name, **inputs):
        node = self.node(name, **inputs)
        while self.tick(node) is Status.RUNNING:
            assert self.context.now < 100.0
        return node

    def write(self, state, **more):
        """Stand where a state wants the hand, and write its row."""
        self.stand(TOUCHED - state.sinks["depth"].value)
        self.context.devices["gripper"] = ScriptedDevice("Gripper", {"opening": 0.055 + state.sinks["stretch"].value})
        inputs = {name: state.sinks[name].value for name in ("geometry", "diameter", "angle", "trial")}
        return self.run("write_row", force=0.5, force_sd=0.01, **inputs, **more)

    def measure(self, rows=None, **inputs):
        """Measure until it is done, or some rows were written; return what was told before each row."""
        node, seen = self.node("next_state", **{**SMALL, **inputs}), []
        while True:
            assert self.tick(node) is Status.SUCCESS
            if node.sinks["done"].value or len(seen) == rows:
                return node, seen
            seen.append(told(node))
            assert self.write(node, table=inputs.get("table", "")).status is Status.SUCCESS


@pytest.fixture
def bench(tmp_path):
    """Make a run of single nodes, in a folder of its own where one is named."""

    def make(folder=None, **devices):
        (folder or tmp_path).mkdir(exist_ok=True)
        return Bench(folder or tmp_path, **devices)

    return make


@pytest.fixture
def saying():
    """Make a force sensor that says what it is told."""
    return Sensor


@pytest.fixture
def small():
    """Return a protocol of eight presses."""
    return SMALL


@pytest.fixture(name="told")
def told_by():
    """Return what `next_state` told of a press."""
    return told
