"""The stand-ins as they are served: faults, control port, processes, the twin behind them, runs over their wires."""

import inspect
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.emulators.control import control
from stretch_bt.hardware.emulators.faults import Fault, Faults
from stretch_bt.hardware.emulators.registry import STAND_INS, stand_in_class
from stretch_bt.hardware.emulators.serve import free_ports, serving, serving_elsewhere
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

FREE = {name: dict.fromkeys(stand_in_class(name).PORTS, 0) for name in STAND_INS}
EMULATE = [sys.executable, "-m", "stretch_bt", "emulate"]
PATIENCE = 30.0


def until(ask):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if answer := ask():
            return answer
        time.sleep(0.01)
    raise AssertionError("it does not come")


@pytest.mark.parametrize("name", STAND_INS)
def test_a_stand_in_says_what_it_is_and_leaves_nothing(name):
    cls = stand_in_class(name)
    assert inspect.getdoc(cls)
    assert all(fault.doc for fault in cls.FAULTS.values())
    before = set(threading.enumerate())
    made = cls("127.0.0.1", StandInWorld(), FREE[name])
    assert set(threading.enumerate()) == before
    for _ in range(2):
        places = made.start()
        assert set(places) >= set(cls.PORTS)
        json.dumps(made.state())
        made.stop()
        made.stop()
        assert set(threading.enumerate()) == before


@pytest.mark.parametrize("name", STAND_INS)
def test_a_port_that_is_taken_leaves_nothing(name):
    before = set(threading.enumerate())
    kind = socket.SOCK_DGRAM if name == "ati" else socket.SOCK_STREAM
    wire = list(FREE[name])[-1]
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            taken.listen()
        ports = {**FREE[name], wire: taken.getsockname()[1]}
        with (
            pytest.raises(OSError, match=r"cannot listen on .* in use; .* Choose another --host"),
            serving([name], StandInWorld(), ports={name: ports}),
        ):
            pass
    assert set(threading.enumerate()) == before


def test_unknown_stand_ins_are_named():
    with pytest.raises(InvalidInput, match="no stand-in 'arm'; there are ur, ur5e, robotiq, urcap, ati, realsense"):
        stand_in_class("arm")
    for names in ([], ["ati", "ati"]):
        with pytest.raises(InvalidInput, match="name each stand-in once"), serving(names, StandInWorld()):
            pass


def test_faults_end_by_count_by_time_and_by_clearing():
    faults = Faults({"a": Fault("one"), "b": Fault("other", {"delay": 0.5})})
    assert faults.take("a") is None
    faults.inject("a", {"times": 2})
    assert [faults.take("a") is not None for _ in range(3)] == [True, True, False]
    faults.inject("b", {"delay": 2, "seconds": 0.05})
    assert faults.shown("b")["delay"] == 2
    assert faults.active() == ["b"]
    until(lambda: faults.shown("b") is None)
    faults.inject("a")
    faults.inject("b")
    faults.clear("a")
    assert faults.active() == ["b"]
    faults.clear()
    assert faults.active() == []


# (what is asked of the control port, part of the answer)
REFUSED = [
    ([], "one JSON object"),
    ({}, "nothing to do that is called None"),
    ({"do": "injekt"}, "did you mean 'inject'"),
    ({"do": "inject", "device": "ati"}, "name the fault"),
    ({"do": "inject", "device": "ato", "fault": "loss"}, "did you mean 'ati'"),
    ({"do": "inject", "device": "ati", "fault": "los"}, "did you mean 'loss'"),
    ({"do": "inject", "device": "ati", "fault": "loss", "prt": 1}, "did you mean 'part'"),
    ({"do": "inject", "device": "ati", "fault": "loss", "part": "1"}, "finite number, not '1'"),
    ({"do": "inject", "device": "ati", "fault": "loss", "part": True}, "finite number"),
    ({"do": "inject", "device": "ati", "fault": "loss", "part": 1e999}, "finite number"),
    ({"do": "inject", "device": "ati", "fault": "slow", "rate": 0}, "rate of the fault 'slow' must be from 0.01 to"),
    ({"do": "inject", "device": "robotiq", "fault": "slow", "delay": -1}, "delay .* must be from 0 to 3600"),
    (
        {"do": "inject", "device": "robotiq", "fault": "code", "code": 99},
        "code of the fault 'code' must be from 0 to 15",
    ),
    ({"do": "inject", "device": "ati", "fault": "load", "fx": 1e300}, "fx .* must be from -1e"),
    ({"do": "inject", "device": "ati", "fault": "load", "fx": 10**400}, "finite number|too large|must be from"),
    ({"do": "inject", "device": "ati", "fault": "load", "times": 2}, "no parameter 'times'"),
    ({"do": "renew"}, "nothing is in the place of an object; name a scene with --scene"),
    ({"do": "renew", "device": "ati"}, "no key 'device' here"),
    ({"do": "clear", "devise": "ati"}, "no key 'devise' here; did you mean 'device'"),
    ({"do": "clear", "device": "ati", "fault": 3}, "a fault has a name"),
    ({"do": "clear", "device": "ati", "fault": "los"}, "did you mean 'loss'"),
]


@pytest.fixture(scope="module")
def served():
    """Stand-ins in this process, with a control port."""
    with serving(["robotiq", "ati"], StandInWorld(), control=0, ports=FREE) as servers:
        yield servers


@pytest.mark.parametrize(("asked", "said"), REFUSED)
def test_what_the_control_port_refuses(served, asked, said):
    with pytest.raises(InvalidInput, match=said):
        control(served.served.control, asked)


def test_the_control_port_lists_injects_and_clears(served):
    def active():
        return control(served.served.control, {"do": "list"})["devices"]["ati"]["active"]

    listed = control(served.served.control, {"do": "list"})["devices"]
    assert set(listed) == {"robotiq", "ati"}
    for name, described in listed.items():
        assert described["wires"] == served.served.wires[name]
        assert set(described["faults"]) == set(stand_in_class(name).FAULTS)
    control(served.served.control, {"do": "inject", "device": "ati", "fault": "loss", "part": 0.5})
    control(served.served.control, {"do": "inject", "device": "ati", "fault": "repeat"})
    assert active() == ["loss", "repeat"]
    control(served.served.control, {"do": "clear", "device": "ati", "fault": "loss"})
    assert active() == ["repeat"]
    control(served.served.control, {"do": "clear"})
    assert active() == []


def test_a_state_ends_when_its_time_has_passed():
    with serving(["robotiq"], StandInWorld(), ports=FREE, activated=True) as servers:
        gripper = servers.stand_ins["robotiq"]
        gripper.inject("code", {"code": 8, "seconds": 0.1})
        assert gripper.state()["fault"] == 8
        until(lambda: gripper.state()["fault"] == 0)
    with serving(["ur"], StandInWorld(), ports=FREE) as servers:
        arm = servers.stand_ins["ur"]
        arm.inject("safeguard_stop", {"seconds": 0.1})
        assert arm.state()["safety"] == "SAFEGUARD_STOP"
        until(lambda: arm.state()["safety"] == "NORMAL")


def test_no_port_but_those_of_the_wires_is_open():
    with serving(["urcap"], StandInWorld(), ports=FREE) as servers:
        assert servers.served.control is None
        assert servers.served.wires["urcap"]["urcap"].startswith("127.0.0.1:")


def test_a_process_of_their_own_ends_with_its_context():
    names = ["robotiq", "ati"]
    with serving_elsewhere(names, host="127.0.0.4", control=0, ports=free_ports(names)) as servers:
        served = servers.served
        assert served.wires["robotiq"]["rtu"].startswith("127.0.0.4:")
        assert control(served.control, {"do": "list"})["devices"]["robotiq"]["state"]["moving"] is False
    with pytest.raises(OSError, match="refused"):
        control(served.control, {"do": "list"})


@pytest.mark.parametrize(("ending", "code"), [("input", 0), (signal.SIGTERM, 130), (signal.SIGINT, 130)])
def test_a_process_ends_when_it_is_told_or_its_parent_is_gone(ending, code):
    """A parent that is killed closes the pipe."""
    command = [*EMULATE, "urcap", "--port", "urcap=0", "--json", "--with-input"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    host, _, port = json.loads(process.stdout.readline())["wires"]["urcap"]["urcap"].partition(":")
    assert host == "127.0.0.2"
    socket.create_connection((host, int(port)), timeout=5).close()
    if ending == "input":
        process.stdin.close()
    else:
        process.send_signal(ending)
    assert process.wait(PATIENCE) == code
    process.stdout.close()
    process.stdin.close()


def test_a_process_that_ends_or_refuses_is_told_with_its_reason():
    names = ["robotiq", "ati"]
    with serving_elsewhere(names, ports=free_ports(names)) as servers:
        servers.check()
        with pytest.raises(InvalidInput, match="did you mean 'loss'"):
            servers.stand_ins["ati"].inject("los")
        os.kill(servers.processes[1].pid, signal.SIGKILL)
        until(lambda: raised(servers.check))
        with pytest.raises(InvalidInput, match=r"the process of ati ended: .* SIGKILL"):
            servers.check()
    with pytest.raises(InvalidInput, match="nowhere"), serving_elsewhere(["ati"], scene="nowhere"):
        pass
    with socket.create_server(("127.0.0.1", 0)) as taken:
        ports = {"urcap": {"urcap": taken.getsockname()[1]}}
        with (
            pytest.raises(InvalidInput, match=r"cannot listen on .* in use"),
            serving_elsewhere(["urcap"], host="127.0.0.1", ports=ports),
        ):
            pass


def raised(check):
    try:
        check()
    except InvalidInput as error:
        return error
    return None


CELL = """\
format: stretch-cell/1
devices:
  gripper:
    type: Gripper
    use: robotiq
    host: HOST
    port: PORT
    model: 2f140
    calibration: {points: [{count: 3, opening: 140 mm}, {count: 230, opening: 0 mm}], source: the stand-in's own}
"""
TREE = """\
format: stretch-tree/1
devices: {gripper: Gripper}
trees:
  main:
    sequence:
      - set_stretch: {stretch: 30 mm, speed: 60 mm/s}
      - set_stretch: {stretch: 0 mm, speed: 100 mm/s}
"""


@pytest.fixture
def gripper_cell(tmp_path):
    with serving(["robotiq"], StandInWorld(), control=0, ports=FREE, activated=True) as servers:
        host, _, port = servers.served.wires["robotiq"]["rtu"].partition(":")
        path = tmp_path / "cell.yaml"
        path.write_text(CELL.replace("HOST", host).replace("PORT", port))
        yield path, servers.stand_ins["robotiq"]


def test_a_tree_runs_over_the_wire(run, gripper_cell):
    path, stand_in = gripper_cell
    result = run(TREE, cell=path)
    assert result.status == "SUCCESS", result.reason
    assert stand_in.state()["opening"] == pytest.approx(0.055, abs=0.001)


def test_a_fault_in_the_middle_ends_the_run_with_the_fingers_at_rest(run, gripper_cell):
    path, stand_in = gripper_cell

    def break_it():
        until(lambda: stand_in.state()["opening"] > 0.060)
        stand_in.inject("code", {"code": 0x0E})

    thread = threading.Thread(target=break_it)
    thread.start()
    result = run(TREE, cell=path)
    thread.join()
    assert result.status == "FAULT"
    assert "fault 0E: too much current" in result.reason
    state = stand_in.state()
    assert not state["moving"]
    assert 0.060 < state["opening"] < 0.085
    assert "fault 0E" in (Path(result.record) / "events.jsonl").read_text()
