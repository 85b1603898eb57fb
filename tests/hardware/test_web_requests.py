"""A page that a browser shows can send a request to any port of loopback; none of its lines is obeyed by a stand-in."""

import json
import socket
import struct
from threading import Thread

import pytest

from stretch_bt.hardware.emulators.control import control
from stretch_bt.hardware.emulators.serve import free_ports, serving
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.wire import package

INJECT = json.dumps({"do": "inject", "device": "ati", "fault": "repeat"}).encode() + b"\n"
SCRIPT = b"def rtde_control():\nend\n" * 2
#: how requests begin that a browser sends across origins without asking
BEGINS = [
    b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://elsewhere\r\nContent-Type: text/plain\r\n\r\n",
    b"GET /status HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
    b"OPTIONS * HTTP/1.0\n\n",
    b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
]


@pytest.fixture(scope="module")
def served():
    names = ["robotiq", "ati"]
    with serving(names, StandInWorld(), control=0, ports=free_ports(names)) as servers:
        yield servers.served


def said(address, *parts):
    """Return all that a port says to parts of a message, until it closes the connection."""
    with socket.create_connection(address, timeout=30) as wire:
        try:
            for part in parts:
                wire.sendall(part)
            return b"".join(iter(lambda: wire.recv(4096), b""))
        except ConnectionError:  # it was closed before all was read
            return b""


def address(text):
    host, _, port = text.rpartition(":")
    return host, int(port)


def active(served):
    return control(served.control, {"do": "list"})["devices"]["ati"]["active"]


@pytest.mark.parametrize("begin", BEGINS)
def test_the_control_port_obeys_no_request(served, begin):
    for parts in ((begin + INJECT,), (begin[:3], begin[3:], INJECT)):
        assert said(served.control, *parts) == b""
        assert active(served) == []


@pytest.mark.parametrize("first", [b"list\n", b"\n", b"[]\n", b'"do"\n', b"\x16\x03\x01\x02\n", b" " * 5000 + b"\n"])
def test_the_control_port_reads_nothing_after_a_first_line_that_is_no_object(served, first):
    answers = said(served.control, first + INJECT + INJECT).splitlines()
    assert [json.loads(answer)["ok"] for answer in answers] in ([False], [])
    assert active(served) == []


def test_a_line_without_end_is_not_kept(served):
    said(served.control, b'{"do": "', b"x" * 10_000, b'"}\n' + INJECT)
    assert active(served) == []


def test_a_port_that_says_nothing_is_an_error():
    with socket.create_server(("127.0.0.1", 0)) as server:
        Thread(target=lambda: server.accept()[0].close(), daemon=True).start()
        with pytest.raises(OSError):
            control(server.getsockname(), {"do": "list"})


@pytest.mark.parametrize("begin", BEGINS)
def test_the_dashboard_obeys_no_request(stand_in, begin):
    made, wires = stand_in("ur")
    before = made.controller.robot_mode
    told = said(address(wires["dashboard"]), begin + b"power off\nstop\nquit\n")
    assert told in (b"", b"Connected: Universal Robots Dashboard Server\n")
    assert made.controller.robot_mode == before
    obeyed = said(address(wires["dashboard"]), b"power off\nquit\n")
    assert b"Powering off" in obeyed
    assert made.controller.robot_mode != before


@pytest.mark.parametrize("wire", ["primary", "secondary", "realtime"])
def test_the_script_ports_take_no_request(stand_in, wire):
    made, wires = stand_in("ur")
    before = list(made.controller.events)
    said(address(wires[wire]), BEGINS[0] + SCRIPT)
    assert list(made.controller.events) == before
    assert not made.controller.running


def test_a_force_sensor_takes_no_request(stand_in):
    _, wires = stand_in("ati")
    bias = struct.pack(">B17xH", 0, 1)
    begin = b"POST / HTTP/1.1\r\n\r\n"
    assert said(address(wires["commands"]), begin.ljust(20) + bias) == b""


def test_a_gripper_takes_no_request(stand_in):
    made, wires = stand_in("urcap")
    before = made.state()
    assert said(address(wires["urcap"]), BEGINS[0] + b"SET POS 200\nSET GTO 1\n") == b""
    assert made.state() == before


ACTIVATE = bytes.fromhex("091003e800030601000000000072e1")


@pytest.mark.parametrize(("wire", "frame"), [("rtu", ACTIVATE), ("tcp", b"\0\1\0\0\0\x0d" + ACTIVATE[:-2])])
def test_a_gripper_by_modbus_takes_no_request(stand_in, wire, frame):
    made, wires = stand_in("robotiq")
    before = made.state()
    with socket.create_connection(address(wires[wire]), timeout=30) as client:
        client.sendall(frame)
        assert client.recv(100)
    assert made.state()["writes"] == before["writes"] + 1
    for parts in ((BEGINS[0] + frame,), (BEGINS[0], frame), (BEGINS[0][:3], BEGINS[0][3:], frame)):
        assert said(address(wires[wire]), *parts) == b""
    assert made.state()["writes"] == before["writes"] + 1


def test_rtde_takes_no_request(stand_in):
    made, wires = stand_in("ur")
    body = package("V", struct.pack(">H", 2)) * 4000
    assert said(address(wires["rtde"]), BEGINS[0] + body) == b""
    assert made.controller.time >= 0
