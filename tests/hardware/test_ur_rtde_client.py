"""Questions by RTDE without a client library: the answers, the clients that they disturb, and peers that are no controllers."""

import contextlib
import socket
import struct
import threading
import time

import numpy as np
import pytest

from stretch_bt.errors import DeviceLost
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.faults import Faults
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel
from stretch_bt.hardware.emulators.ur.controller import Controller, ControllerModel
from stretch_bt.hardware.emulators.ur.rtde_server import RtdeServer
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.ur.kinematics import MODELS
from stretch_bt.hardware.ur.look import look
from stretch_bt.hardware.ur.options import UrOptions
from stretch_bt.hardware.ur.rtde import Rtde
from stretch_bt.hardware.ur.version import is_polyscope_x

REGISTER = "input_int_register_24"


@pytest.fixture(params=[Ur5StandIn, Ur5eStandIn])
def behind(request, own_hosts):
    """A stand-in."""
    made = request.param(next(own_hosts), StandInWorld())
    made.start()
    yield made
    made.stop()


def options_at(host):
    """Return the options of an arm at an address."""
    return UrOptions.model_validate(
        {
            "type": "Arm",
            "use": "ur",
            "host": host,
            "model": "ur5",
            "base": {"x": "-500 mm"},
            "hand": {},
            "source": "the stand-in's own",
        }
    )


def test_it_tells_what_the_controller_has(behind):
    with Rtde(behind.host) as controller:
        assert controller.version() == behind.PROFILE.version
        running, turning, stamp = controller.read(["runtime_state", "target_qd", "timestamp"])
        assert (running, turning) == (1, (0.0,) * 6)
        assert controller.read(["timestamp"])[0] > stamp
        with pytest.raises(OSError, match="does not have all of no_such_thing"):
            controller.read(["no_such_thing"])


def test_it_takes_nothing_that_is_in_use_and_keeps_nothing(behind):
    with Rtde(behind.host) as one:
        assert one.claim(REGISTER)
        with Rtde(behind.host) as other:
            assert other.claim(REGISTER) is None
            assert other.claim("input_int_register_25")
            with pytest.raises(OSError, match="no_such_thing is not to be had"):
                other.claim("no_such_thing")
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        with Rtde(behind.host) as third:
            if third.claim(REGISTER):
                return
    raise AssertionError("the register is not free again")


PEERS = {
    "silent": None,
    "gone": b"",
    "web": b"HTTP/1.1 400 Bad Request\r\n\r\n",
    "endless": struct.pack(">HB", 9, ord("M")) * 3000,
    "short": struct.pack(">HB", 4, ord("V")),
    "refused": struct.pack(">HBB", 4, ord("V"), 0),
    "empty": struct.pack(">HB", 0, ord("V")),
}


@pytest.mark.parametrize("answer", PEERS.values(), ids=PEERS)
def test_a_peer_that_is_no_controller_is_left_in_time(own_hosts, answer):
    host = next(own_hosts)
    with socket.create_server((host, 30004)) as server:

        def serve():
            connection, _ = server.accept()
            with connection, contextlib.suppress(OSError):
                connection.recv(100)
                if answer is not None:
                    connection.sendall(answer)
                if answer != b"":
                    connection.recv(100)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        begun = time.monotonic()
        with pytest.raises(OSError):
            Rtde(host, within=0.5)
        assert time.monotonic() - begun < 5.0
        thread.join(10)


@pytest.fixture
def polyscope_x(own_hosts):
    """A controller with PolyScope X as far as it is asked here: RTDE of version 10, and no dashboard."""
    arm = ArmModel(MODELS["ur5e"], [0.0, -1.6, 1.8, -1.8, -1.5708, 0.0])
    faults = Faults({})
    controller = Controller(
        ControllerModel((10, 7, 0, 1), 500.0, "UR5", "1"), arm, lambda: tuple(np.zeros(6)), faults.shown
    )
    host = next(own_hosts)
    server = RtdeServer(host, 30004, controller, faults).server
    yield host
    server.stop()


def test_polyscope_x_is_known_and_told(polyscope_x, behind):
    assert is_polyscope_x(polyscope_x)
    assert not is_polyscope_x(behind.host)
    assert not is_polyscope_x("127.0.0.251")
    options = options_at(polyscope_x)
    found = {finding.check: finding for finding in look("arm", options, Limits())}
    assert "no answer" in found["arm: network"].detail
    assert "PolyScope X, which is not supported" in found["arm: controller"].detail
    halted = options.halt("arm")
    assert (halted.ok, "PolyScope X, which is not supported" in halted.detail) == (False, True)
    assert "PolyScope X" not in options_at("127.0.0.251").halt("arm").detail


@pytest.mark.parametrize("version", [(3, 9), (3, 11), (3, 12), (3, 15), (5, 3), (5, 5), (5, 6), (5, 11)])
@pytest.mark.parametrize("model", ["ur5", "ur5e"])
def test_a_controller_is_held_against_its_model_at_every_version(own_hosts, monkeypatch, version, model):
    """Below 3.12 and 5.6 its dashboard does not know which model it is of."""
    kind = Ur5eStandIn if version[0] == 5 else Ur5StandIn
    monkeypatch.setattr(kind, "PROFILE", kind.PROFILE._replace(version=(*version, 1, 64192)))
    made = kind(next(own_hosts), StandInWorld())
    made.start()
    try:
        options = options_at(made.host).model_copy(update={"model": model})
        [found] = [one for one in look("arm", options, Limits()) if one.check == "arm: controller"]
    finally:
        made.stop()
    assert found.ok is (model == kind.MODEL), found
    assert "could not understand" not in found.detail


def test_an_arm_with_polyscope_x_is_not_opened(polyscope_x, live_cell):
    spec = load_cell(live_cell("ur", "rtde", polyscope_x))
    with pytest.raises(DeviceLost, match="PolyScope X, which is not supported; use a UR5 with PolyScope 3"):
        open_cell(spec, now=time.monotonic)
