"""What every implementation of a device keeps to: the public contract, on twins, a recording, stand-ins, and a cell of one's own."""

import atexit
import inspect
import os
import shutil
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import pytest
from conftest import librealsense
from lab import lab_cell
from live_cells import HOSTS, LIVE, OWN_ADDRESS, recording, write_live_cell, write_recording
from real_cell import CELL, MOVE, contracts

from stretch_bt.frames import Pose
from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.implementations import SHIPPED, driver_class
from stretch_bt.testing import device_contract

#: wires on which a gripper behaves as on the first one; the test that it moves there is in the default run
ALIKE = ("robotiq-tcp", "robotiq-serial")
FINGERS = {"moves": (0.055, 0.085), "tolerance": 0.001, "latency": 0.15}
HAND = {
    "moves": (Pose((0.0, 0.0, 0.2)), Pose((0.03, 0.0, 0.2), (0.0, 0.1, 0.15))),
    "tolerance": 0.0005,
    "latency": 0.15,
}
#: of a device that goes by the clock of the test
EXACT = {"tolerance": 1e-9, "latency": 0.15}
OF_LIVE = {
    **dict.fromkeys(("robotiq-rtu", "robotiq-tcp", "robotiq-serial", "urcap"), ("gripper", "Gripper", FINGERS)),
    "ur": ("arm", "Arm", HAND),
    "ati": (
        "force_sensor",
        "ForceSensor",
        {"tolerance": 0.5, "latency": 0.15, "load": lambda served: served.made.inject("load", {"fz": 5.0})},
    ),
    "realsense": ("camera", "DepthCamera", {"tolerance": 0.001, "latency": 0.2}),
}
#: options of a cell file with which a loss is reported soon
SOON = {"realsense": {"lost_after": "1 s"}}


class Served:
    """A stand-in on free ports of loopback, going by the machine's clock."""

    def __init__(self, kind):
        use, server, wire = LIVE[kind]
        if kind == "realsense":
            librealsense()
        cls = stand_in_class(server)
        own = server in OWN_ADDRESS
        host, ports = (next(HOSTS), {}) if own else ("127.0.0.1", dict.fromkeys(cls.PORTS, 0))
        self.made = cls(host, StandInWorld(now=time.monotonic), ports)
        self.made.activated()
        self.folder = tempfile.TemporaryDirectory()
        place = self.made.start()[wire]
        self.cell = write_live_cell(Path(self.folder.name), use, wire, place, **SOON.get(kind, {}))

    def cut(self):
        """Close its ports and every connection."""
        self.made.stop()

    def stop(self):
        """End it."""
        self.made.stop()
        self.folder.cleanup()


def live(kind):
    """Return the contract of a device on its stand-in."""
    device, type_, terms = OF_LIVE[kind]
    made = device_contract(
        lambda served: served.cell, device, kind=type_, start=partial(Served, kind), cut=Served.cut, **terms
    )
    made.pytestmark = [pytest.mark.slow] if kind in ALIKE else []
    return made


def recorded():
    """Write a recording, of a load that grows from some 35 N, and the cell that plays it."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return write_recording(folder, wrench=20.0 + recording()["wrench"])


def press(sensor):
    """Press the simulated hand onto the object of the scene."""
    twin = sensor.driver.cell.twin
    twin.place(Pose((0.0, 0.0, twin.truth()["contact_height"] - 0.005)))


REPLAYED = recorded()
TestSimulatedArm = device_contract("simulated", "arm", moves=HAND["moves"], **EXACT)
TestSimulatedGripper = device_contract("simulated", "gripper", moves=FINGERS["moves"], **EXACT)
TestSimulatedCamera = device_contract("simulated", "camera", **EXACT)
TestSimulatedForceSensor = device_contract("simulated", "force_sensor", tolerance=0.1, latency=0.15, load=press)
TestReplayArm = device_contract(REPLAYED, "arm", **EXACT)
TestReplayCamera = device_contract(REPLAYED, "camera", **EXACT)
TestReplayForceSensor = device_contract(REPLAYED, "force_sensor", tolerance=10.0, latency=0.15)
globals().update({f"Test_{kind.replace('-', '_')}": live(kind) for kind in OF_LIVE})
globals().update(contracts())


def test_every_implementation_is_held_to_it():
    simulated = {(kind, "simulated") for kind in ("Arm", "Gripper", "DepthCamera", "ForceSensor")}
    replayed = {(kind, "replay") for kind in ("Arm", "DepthCamera", "ForceSensor")}
    wired = {(type_, LIVE[kind][0]) for kind, (_, type_, _) in OF_LIVE.items()}
    people = {("Operator", "simulated"), ("Operator", "console")}  # in tests of their own
    assert simulated | replayed | wired | people == set(SHIPPED)


def test_drivers_document_themselves():
    for key in SHIPPED:
        cls = driver_class(*key)
        assert inspect.getdoc(cls)
        assert cls.Options.model_fields["type"].annotation.__args__ == (key[0],)
        assert cls.Options.model_fields["use"].annotation.__args__ == (key[1],)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({CELL: "nowhere.yaml"}, "nowhere"),
        ({CELL: "lab_ur5", MOVE: "arm,gripper"}, "nothing that moves named arm,gripper; write names of"),
        ({CELL: "lab_ur5", MOVE: "arm camera"}, "nothing that moves named camera"),
    ],
)
def test_a_cell_of_ones_own_that_is_asked_for_wrongly_is_refused_at_once(monkeypatch, told, said):
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    for name in (CELL, MOVE):
        monkeypatch.delenv(name, raising=False)
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(pytest.UsageError, match=said):
        contracts()


@pytest.mark.parametrize(
    ("told", "moving"),
    [({MOVE: "arm"}, None), ({CELL: "lab_ur5"}, []), ({CELL: "lab_ur5", MOVE: "arm"}, ["TestHardware_arm"])],
    ids=["no cell", "nothing to move", "an arm"],
)
def test_nothing_moves_that_was_not_asked_for(monkeypatch, told, moving):
    for name in (CELL, MOVE, "PYTEST_XDIST_WORKER"):
        monkeypatch.delenv(name, raising=False)
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    found = contracts()
    if moving is None:
        assert found == {}
    else:
        assert [name for name, made in found.items() if made.contract.moves is not None] == moving


@pytest.mark.slow
def test_a_cell_file_of_ones_own_is_held_to_all_of_this(own_hosts, librealsense, tmp_path):
    """Stand-ins take the place of the hardware."""
    host = next(own_hosts)
    names = ("arm", "gripper", "force_sensor", "camera")
    (tmp_path / "own.yaml").write_text(lab_cell(host, {name: {} for name in names}))
    told = {CELL: str(tmp_path / "own.yaml"), MOVE: "arm gripper"}
    with serving(["ur", "robotiq", "ati", "realsense"], StandInWorld(), host=host, activated=True):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-rs", __file__, "-k", "TestHardware"],
            env={**{k: v for k, v in os.environ.items() if not k.startswith("PYTEST_XDIST")}, **told},
            capture_output=True,
            text=True,
            check=False,
        )
    print(done.stdout)  # noqa: T201
    assert done.returncode == 0, done.stdout
