"""Single nodes of a characterisation, on scripted devices."""

from functools import partial

import pytest

from stretch_bt.behaviors.records import Touch
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.runtime.context import RunContext
from stretch_bt.testing import ScriptedDevice
from stretch_bt.tree.ports import MISSING, Cell, Role, Status
from stretch_bt.tree.registry import lookup

TOUCHED = 0.060
SMALL = {"diameters": [0.02, 0.03], "stretches": [0.0, 0.01], "depths": [0.0, 0.002], "trials": 1}


class Sensor:
    """A force sensor that gives scripted forces, with the number of each reading; the last one stays."""

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
    """A run of single nodes: one context, a clock, and devices and keys that stay from node to node.

    A record that a node is not given it shares under the name of its port, as nodes of a tree do.
    """

    def __init__(self, folder, **devices):
        self.context = RunContext()
        self.context.folder = folder
        self.context.about = {"scene": "calibration_sphere", "seed": 4, "versions": {}}
        self.keys = {"touch": Cell("touch", Touch(TOUCHED, 1e-4))}
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
            read = self.shared(port) if info.types[port.name].is_record else lambda port=port: port.default
            node.wiring[port.name] = partial(inputs.get, port.name) if port.name in inputs else read
        for port in (p for p in info.ports.values() if p.written and info.types[p.name].is_record):
            node.sinks[port.name] = self.keys.setdefault(port.name, node.sinks[port.name])
            if port.name in inputs:
                node.sinks[port.name].write(inputs[port.name])
        return node

    def shared(self, port):
        """Return a function that reads the key of the port's name, or gives the port's default where it is unset."""
        key = self.keys.get(port.name, Cell(port.name))
        return key.read if port.required else lambda: port.default if key.value is MISSING else key.value

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

    def left(self):
        """Return the presses that the latest plan left: indenter, trial and depth of each, in their order."""
        indenters = self.keys["left"].value.indenters
        return [
            (indenter, trial, depth) for indenter in indenters for trial in indenter.trials for depth in trial.depths
        ]

    def write(self, name, press, **more):
        """Stand where a press wants the hand, and write its row."""
        indenter, trial, depth = press
        self.stand(TOUCHED - depth)
        self.context.devices["gripper"] = ScriptedDevice("Gripper", {"opening": 0.055 + trial.stretch})
        return self.run(name, indenter=indenter, trial=trial, **more)

    def measure(self, rows=None, **inputs):
        """Plan, and measure all that is left, or so many rows; return the plan, and the presses that were made."""
        plan = self.run("plan_protocol", **{**SMALL, **inputs})
        assert plan.status is Status.SUCCESS, plan.reason
        made = self.left()[:rows]
        for press in made:
            assert self.write("write_row", press, force=0.5, force_sd=0.01).status is Status.SUCCESS
        return plan, made


@pytest.fixture
def bench(tmp_path):
    """Make a run of single nodes, in a folder of its own where one is named."""

    def make(folder=None, **devices):
        (folder or tmp_path).mkdir(exist_ok=True)
        return Bench(folder or tmp_path, **devices)

    return make


@pytest.fixture
def saying():
    """Make a force sensor that gives scripted forces."""
    return Sensor


@pytest.fixture
def small():
    """Return a protocol of eight presses."""
    return SMALL
