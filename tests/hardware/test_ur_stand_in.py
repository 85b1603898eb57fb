"""The stand-ins for UR controllers as the real clients see them, and one that was written elsewhere."""

import json
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.arm_model import ArmModel
from stretch_bt.hardware.emulators.ur.controller import Controller
from stretch_bt.hardware.emulators.ur.script import parse_script
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.emulators.ur.wire import LONGEST, TYPES, Packages, Unpackable, pack, package, unpack
from stretch_bt.hardware.transforms import rotation_vector, six, transform
from stretch_bt.hardware.ur.kinematics import MODELS

MODELS_OF = {"ur": Ur5StandIn, "ur5e": Ur5eStandIn}
CLIENTS = Path(__file__).with_name("ur_clients.py")


@pytest.fixture
def controller(own_hosts):
    """Start a stand-in at a loopback address of its own."""
    started = []

    def start(model="ur"):
        made = MODELS_OF[model](next(own_hosts), StandInWorld())
        started.append(made)
        made.start()
        return made

    yield start
    for one in started:
        one.stop()


def clients(program, host):
    done = subprocess.run([sys.executable, CLIENTS, program, host], capture_output=True, timeout=90, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize("model", ["ur", pytest.param("ur5e", marks=pytest.mark.slow)])
def test_the_real_clients_find_a_controller(controller, model):
    stand_in = controller(model)
    found = clients("tour", stand_in.host)
    second, said = found.pop("second client"), found.pop("dashboard")
    assert "already in use" in second
    version = ".".join(map(str, stand_in.PROFILE.version))
    assert said == ["Robotmode: RUNNING", "Safetymode: NORMAL", version]
    flags = {name: value for name, value in found.items() if isinstance(value, bool)}
    assert [name for name, value in flags.items() if value is not True] == []
    offsets = {name: value for name, value in found.items() if name not in flags}
    assert len(offsets) > 8
    assert all(value < 1e-5 for value in offsets.values()), offsets
    assert "watchdog" in str(stand_in.state()["events"])


def test_a_cb3_has_no_contact_detection_and_says_that_it_is_done(controller):
    stand_in = controller("ur")
    before = stand_in.state()["height"]
    assert clients("contact", stand_in.host) == {"done": True}
    assert stand_in.state()["height"] == before
    newer = controller("ur5e")
    newer.inject("wall", {"height": 0.19, "stiffness": 1000})
    assert clients("contact", newer.host) == {"done": True}
    # 5 N are felt 5 mm within the wall, or sooner with the noise of the force; a machine that is late looks at them a moment later
    assert 0.18 < newer.state()["height"] < 0.188


@pytest.mark.parametrize("model", [pytest.param("ur", marks=pytest.mark.slow), "ur5e"])
def test_a_program_of_ones_own_runs_between_those_of_the_client(controller, model):
    found = clients("custom", controller(model).host)
    assert found == dict.fromkeys(found, True)


def test_a_protective_stop_is_unlocked_when_its_time_has_passed(controller):
    stand_in = controller()
    found = clients("lock", stand_in.host)
    assert "until 5s" in found.pop("too soon")
    assert found == {"triggered": False, "stopped": True}
    stand_in.stop()
    for _ in range(5 * 125):
        stand_in.controller.cycle()
    assert stand_in.controller.unlock()
    assert stand_in.state()["safety"] == "NORMAL"


def test_the_client_of_the_maker_reads_and_sets(controller):
    rtde = pytest.importorskip("rtde.rtde", reason="the maker's own client is not installed")
    stand_in = controller()
    client = rtde.RTDE(stand_in.host)
    client.connect()
    try:
        assert client.get_controller_version() == stand_in.PROFILE.version
        names = ["timestamp", "actual_q", "actual_TCP_pose", "runtime_state", "safety_status_bits"]
        kinds = ["DOUBLE", "VECTOR6D", "VECTOR6D", "UINT32", "UINT32"]
        assert client.send_output_setup(names, kinds, frequency=125)
        inputs = client.send_input_setup(["input_int_register_40", "input_double_register_40"], ["INT32", "DOUBLE"])
        inputs.input_int_register_40, inputs.input_double_register_40 = 7, 1.5
        assert client.send_start()
        assert client.send(inputs)
        states = [client.receive() for _ in range(20)]
        assert client.send_pause()
    finally:
        client.disconnect()
    times = [state.timestamp for state in states]
    assert np.diff(times).min() > 0
    assert states[-1].actual_q == pytest.approx(stand_in.arm.q.tolist())
    assert (states[-1].runtime_state, states[-1].safety_status_bits) == (1, 1)
    assert stand_in.controller.registers.in_int[40] == 7
    assert stand_in.controller.registers.in_double[40] == 1.5


# --- bytes


KINDS = st.lists(st.sampled_from(sorted(TYPES)), min_size=1, max_size=6)


@given(st.data(), KINDS)
def test_values_come_back_from_their_bytes(data, kinds):
    size = struct.calcsize(">" + "".join(TYPES[kind] for kind in kinds if kind != "BOOL")) + kinds.count("BOOL")
    payload = data.draw(st.binary(min_size=size, max_size=size))
    values = unpack(kinds, payload)
    assert len(values) == len(kinds)
    again = unpack(kinds, pack(kinds, values))
    assert np.array_equal(np.hstack(again).astype(float), np.hstack(values).astype(float), equal_nan=True)
    with pytest.raises(Unpackable):
        unpack(kinds, payload + b"\0")


@given(st.lists(st.tuples(st.sampled_from("VvOISPUM"), st.binary(max_size=40)), max_size=5), st.integers(1, 50))
def test_packages_are_found_however_they_come(sent, piece):
    data = b"".join(package(kind, payload) for kind, payload in sent)
    packages = Packages()
    found = [p for k in range(0, len(data), piece) for p in packages.feed(data[k : k + piece])]
    assert found == sent


@given(st.binary(max_size=300))
def test_any_bytes_are_packages_or_refused(data):
    packages = Packages()
    try:
        for kind, payload in packages.feed(data):
            assert len(kind) == 1
            assert len(payload) <= LONGEST
    except Unpackable:
        pass


@given(st.text(max_size=300) | st.text("movel(p[]0123456789.e+-,=ravb) \n", max_size=200))
def test_any_text_is_a_program_or_not(text):
    assert parse_script(text) is None
    whole = f"def rtde_control():\n# float register offset\n24\n# int register offset\n24\n{text}"
    parsed = parse_script(whole)
    assert parsed is None or parsed[0] in (0, 24)


ANY_PACKAGE = st.builds(package, st.sampled_from("VvOISPUM~"), st.binary(max_size=80))


@settings(max_examples=30, deadline=None)
@given(st.lists(ANY_PACKAGE | st.binary(max_size=60), min_size=1, max_size=6))
def test_no_bytes_move_the_arm_or_stop_the_controller(noisy, sent):
    with socket.create_connection((noisy.host, 30004), timeout=5) as wire:
        wire.sendall(b"".join(sent))
    with socket.create_connection((noisy.host, 29999), timeout=5) as wire:
        wire.sendall(b"".join(sent).replace(b"\n", b"") + b"\nrobotmode\n")
        with wire.makefile("rb") as answers:
            replies = [answers.readline() for _ in range(3)]
    assert replies[-1] == b"Robotmode: RUNNING\n" or b"Disconnected\n" in replies
    with socket.create_connection((noisy.host, 30003), timeout=5) as wire:
        wire.sendall(b"".join(sent) + b"\nend\n")
    assert noisy.state()["moved"] == 0.0


@pytest.fixture(scope="module")
def noisy(own_hosts):
    made = Ur5StandIn(next(own_hosts), StandInWorld())
    made.start()
    yield made
    end = time.monotonic() + 10
    before = made.state()["time"]
    while made.state()["time"] < before + 0.1:
        assert time.monotonic() < end, "its cycles have ended"
        time.sleep(0.01)
    assert not made.state()["running"]
    made.stop()


# --- kinematics


@pytest.mark.parametrize(("model", "upright"), [("ur5", (0.0, -0.19145, 1.001059)), ("ur5e", (0.0, -0.2329, 1.0794))])
def test_the_upright_arm_is_where_the_data_sheets_have_it(model, upright):
    """Sums of the link lengths by hand: height d1 - a2 - a3 + d5, sideways -(d4 + d6)."""
    assert six(MODELS[model].forward([0, -np.pi / 2, 0, -np.pi / 2, 0, 0]))[:3] == pytest.approx(upright, abs=1e-9)


ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6)


@pytest.mark.parametrize("model", MODELS)
@settings(max_examples=60, deadline=None)
@given(ANGLES, st.lists(st.floats(-0.03, 0.03), min_size=6, max_size=6))
def test_joint_angles_come_back_from_the_pose(model, q, off):
    kinematics = MODELS[model]
    if kinematics.margin(q) < 0.25:
        return
    assert kinematics.inverse(kinematics.forward(q), np.add(q, off)) == pytest.approx(q, abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(ANGLES, st.integers(0, 5))
def test_the_jacobian_is_the_derivative(q, joint):
    kinematics, step = MODELS["ur5e"], 1e-6
    more = kinematics.forward([v + step * (k == joint) for k, v in enumerate(q)])
    less = kinematics.forward([v - step * (k == joint) for k, v in enumerate(q)])
    turn = rotation_vector(more[:3, :3] @ less[:3, :3].T)
    found = np.concatenate([more[:3, 3] - less[:3, 3], turn]) / (2 * step)
    assert kinematics.jacobian(q)[:, joint] == pytest.approx(found, abs=1e-6)


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3), st.floats(0, np.pi))
def test_rotation_vectors_come_back_from_matrices(axis, angle):
    norm = np.linalg.norm(axis)
    if norm < 1e-3:
        return
    vector = np.array(axis) / norm * angle
    matrix = transform([0, 0, 0, *vector])[:3, :3]
    assert transform([0, 0, 0, *rotation_vector(matrix)])[:3, :3] == pytest.approx(matrix, abs=1e-9)


def test_what_is_out_of_reach_has_no_joint_angles():
    with pytest.raises(IllConditioned, match="out of reach"):
        MODELS["ur5"].inverse(transform([1.5, 0, 0, 0, 0, 0]), [0.1] * 6)


def test_a_move_that_cannot_go_on_is_a_protective_stop():
    arm = ArmModel(MODELS["ur5"], Ur5StandIn("127.0.0.1", StandInWorld()).arm.q.tolist())
    controller = Controller(Ur5StandIn.PROFILE, arm, lambda: (0.0,) * 6, lambda fault: None)
    from stretch_bt.hardware.emulators.ur.arm_model import LineMove

    arm.move = LineMove(arm, [[3.0, 0.0, 0.5, 0.0, 0.0, 0.0]], 1.0, 5.0)
    for _ in range(1000):
        controller.cycle()
    assert controller.safety.name == "PROTECTIVE_STOP"
    assert arm.steady
