"""Own nodes that ask devices for anything that is public replay as they ran."""

import os
import sys

import pytest

from stretch_bt.errors import DeviceLost, StaleReading
from stretch_bt.frames import Wrench
from stretch_bt.hardware.interfaces import Reading
from stretch_bt.hardware.simulated.arm import SimulatedArm
from stretch_bt.hardware.simulated.force_sensor import SimulatedForceSensor
from stretch_bt.runtime.replay import replay
from stretch_bt.runtime.task import run
from stretch_bt.tree import registry

MODULE = '''\
import os
import signal

from stretch_bt import Behavior, Out, Status, Uses, node
from stretch_bt.frames import Pose
from stretch_bt.hardware.interfaces import Arm, DepthCamera, ForceSensor, Gripper, MotionState


@node
class Asks(Behavior):
    """Ask all devices for what they say of themselves."""
    camera: Uses[DepthCamera]
    gripper: Uses[Gripper]
    focal: Out[float]
    said: Out[str]

    def initialise(self):
        self.focal = float(self.camera.intrinsics.fx)
        self.camera.frame(1.0)
        self.motion = self.gripper.activate(owner=self.path)

    def update(self):
        self.said = f"{self.gripper.state} {self.camera.state}"
        return Status.SUCCESS if self.motion.poll() is MotionState.DONE else Status.RUNNING


@node
class AsksWrongly(Behavior):
    """Ask for an opening of no age."""
    gripper: Uses[Gripper]

    def update(self):
        self.gripper.opening(0)
        return Status.SUCCESS


@node
class Zeroes(Behavior):
    """Zero the force."""
    force_sensor: Uses[ForceSensor]

    def update(self):
        self.force_sensor.zero()
        return Status.SUCCESS


@node
class GoesUp(Behavior):
    """Move the arm without a look at its place."""
    arm: Uses[Arm]
    up: Out[float]

    def initialise(self):
        self.motion = self.arm.move(Pose((0.0, 0.0, 0.25)), speed=0.02, owner=self.path)

    def update(self):
        self.up = 1.0
        return Status.SUCCESS if self.motion.poll() is MotionState.DONE else Status.RUNNING


@node
class Twice(Behavior):
    """Be stopped by a Ctrl-C, and have another come while it is stopped."""

    def initialise(self):
        self.ticks = 0

    def update(self):
        self.ticks += 1
        if self.ticks == 3 and "TWICE" in os.environ:
            os.kill(os.getpid(), signal.SIGINT)
        return Status.RUNNING

    def terminate(self, new_status):
        if "TWICE" in os.environ:
            os.kill(os.getpid(), signal.SIGINT)
'''
HEAD = "format: stretch-tree/1\nimports: {own: asks_devices}\n"
#: what an own node does, how its run ends, and what a driver does instead
CASES = {
    "intrinsics, state and activate": ("camera: DepthCamera, gripper: Gripper", "sequence: [asks]", "SUCCESS", None),
    "an age that is none": ("gripper: Gripper", "sequence: [asks_wrongly]", "ERROR", None),
    "a zero that is refused": (
        "force_sensor: ForceSensor",
        "sequence: [zeroes, wait: {duration: 1 s}]",
        "FAULT",
        "old",
    ),
    "a zero on a lost wire": (
        "force_sensor: ForceSensor",
        "sequence: [zeroes, wait: {duration: 1 s}]",
        "FAULT",
        "lost",
    ),
    "a force that is allowed until it moves": (
        "arm: Arm",
        "sequence: [set: {felt: arm.force}, goes_up, set: {told: felt}]",
        "FAULT",
        "pushed",
    ),
}


def refused(sensor):
    raise StaleReading(sensor.name, "the latest measurement is 0.5 s old")


def lost(sensor):
    raise DeviceLost(sensor.name, "the connection broke")


def pushed(arm):
    now = arm.cell.now()
    return Reading(Wrench((0.0, 0.0, 90.0)), now, now, round(1e3 * now))


INSTEAD = {
    "old": (SimulatedForceSensor, "zero", refused),
    "lost": (SimulatedForceSensor, "zero", lost),
    "pushed": (SimulatedArm, "wrench", pushed),
}


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    """Return a function that runs a tree of such nodes, and replays its record as in another process."""
    monkeypatch.setattr(registry, "_nodes", dict(registry.load_all()))
    (tmp_path / "asks_devices.py").write_text(MODULE)

    def again(body, instead=None):
        (tmp_path / "tree.yaml").write_text(HEAD + body)
        with monkeypatch.context() as patched:
            if instead is not None:
                patched.setattr(*INSTEAD[instead])
            result = run(tmp_path / "tree.yaml", out=tmp_path / "record")
        os.environ.pop("TWICE", None)
        sys.modules.pop("asks_devices")
        return result, replay(tmp_path / "record", trust=True)

    yield again
    sys.modules.pop("asks_devices", None)


@pytest.mark.parametrize("name", CASES)
def test_what_an_own_node_asks_of_a_device_replays_as_it_was(recorded, name):
    devices, body, status, instead = CASES[name]
    result, found = recorded(f"devices: {{{devices}}}\nscene: water_balloon\ntrees: {{main: {{{body}}}}}\n", instead)
    assert result.status == status, result.reason
    assert found.identical, found.first_difference


def test_a_second_interrupt_while_nodes_are_stopped_is_in_the_record(recorded, monkeypatch):
    monkeypatch.setenv("TWICE", "1")
    result, found = recorded("trees: {main: {sequence: [twice], finally: [wait: {duration: 0.1 s}]}}\n")
    assert result.status == "INTERRUPTED"
    assert "was not run: stopped twice" in result.reason + "".join(map(str, result.errors or []))
    assert found.identical, found.first_difference
