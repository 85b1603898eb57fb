"""Clients of a gripper as others write them: what they send, and what they take for an answer, on each wire of the stand-ins."""

import os
import select
import socket
import struct
import time
import tty
from contextlib import contextmanager

import pytest
from waiting import eventually

from stretch_bt.hardware.emulators.modbus import crc16
from stretch_bt.hardware.emulators.robotiq import RobotiqStandIn
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.urcap import QUESTIONS, UrcapStandIn
from stretch_bt.hardware.robotiq.registers import ObjectStatus
from stretch_bt.hardware.robotiq.urcap_wire import UrcapWire

STATUS, COMMAND = 2000, 1000
PATIENCE = 10.0
HASTE = 20.0


class Rtu:
    """Frames with a CRC, over anything that can be read and written as a file."""

    def __init__(self, file):
        self._file = file

    def ask(self, *pdu):
        body = bytes([9, *pdu])
        os.write(self._file, body + crc16(body).to_bytes(2, "little"))
        answer = b""
        while len(answer) < 5 or crc16(answer):
            ready, _, _ = select.select([self._file], [], [], PATIENCE)
            assert ready, f"no answer, only {answer.hex()}"
            answer += os.read(self._file, 256)
        assert answer[0] == 9
        return answer[1:-2]


class Tcp:
    """Frames with a header that counts them."""

    def __init__(self, connection):
        self._connection, self._number = connection, 0

    def ask(self, *pdu):
        self._number += 1
        self._connection.sendall(struct.pack(">HHHB", self._number, 0, 1 + len(pdu), 9) + bytes(pdu))
        answer = b""
        while len(answer) < 7 or len(answer) < 6 + int.from_bytes(answer[4:6], "big"):
            answer += self._connection.recv(256)
        assert answer[:4] == struct.pack(">HH", self._number, 0)
        return answer[7:]


@contextmanager
def connected(place):
    host, _, port = place.partition(":")
    with socket.create_connection((host, int(port)), timeout=PATIENCE) as connection:
        yield connection


@contextmanager
def asking(wire, places):
    """Return a client on a wire of the stand-in."""
    if wire == "serial":
        file = os.open(places[wire], os.O_RDWR | os.O_NOCTTY)
        tty.setraw(file)
        try:
            yield Rtu(file)
        finally:
            os.close(file)
        return
    with connected(places[wire]) as connection:
        yield Tcp(connection) if wire == "tcp" else Rtu(connection.fileno())


@pytest.fixture
def served():
    """Start a stand-in whose clock is faster than the machine's."""
    begun = []

    def start(kind):
        made = kind("127.0.0.1", StandInWorld(now=lambda: HASTE * time.monotonic()), dict.fromkeys(kind.PORTS, 0))
        begun.append(made)
        return made, made.start()

    yield start
    for made in begun:
        made.stop()


def words(*values):
    return struct.pack(f">{len(values)}H", *values)


def by_one(client, start, values):
    for k, value in enumerate(values):
        told = words(start + k, value)
        assert client.ask(6, *told) == bytes([6]) + told


def by_some(client, start, values):
    for k, value in enumerate(values):
        assert client.ask(16, *words(start + k, 1), 2, *words(value)) == bytes([16]) + words(start + k, 1)


def by_all(client, start, values):
    told = words(start, len(values))
    assert client.ask(16, *told, 2 * len(values), *words(*values)) == bytes([16]) + told


def and_read(client, start, values):
    told = (*words(STATUS, 3), *words(start, len(values)), 2 * len(values), *words(*values))
    assert client.ask(23, *told)[:2] == bytes([23, 6])


def status(client, function):
    answer = client.ask(function, *words(STATUS, 3))
    assert answer[:2] == bytes([function, 6])
    return struct.unpack(">3H", answer[2:])


@pytest.mark.parametrize("write", [by_one, by_some, by_all, and_read])
@pytest.mark.parametrize("wire", ["rtu", "tcp", "serial"])
def test_a_gripper_is_activated_and_moved_with_every_function(served, wire, write):
    stand_in, places = served(RobotiqStandIn)
    stand_in.activated()
    with asking(wire, places) as client:
        write(client, COMMAND, [0x0100])
        assert status(client, 3) == status(client, 4)
        write(client, COMMAND + 1, [150, 0xFF40])
        write(client, COMMAND, [0x0900])
        eventually(lambda: status(client, 4)[0] >> 14 == 3)
        assert status(client, 3)[1:] == (150, 150 << 8)
        assert client.ask(3, *words(COMMAND, 3)) == bytes([3, 6]) + words(0x0900, 150, 0xFF40)
        assert client.ask(6, *words(STATUS, 1)) == bytes([0x86, 2])
        assert client.ask(1, *words(0, 1)) == bytes([0x81, 1])


@pytest.mark.parametrize("write", [by_one, by_some, by_all, and_read])
def test_an_activation_with_a_motion_behind_it_ends_there(served, write):
    _, places = served(RobotiqStandIn)
    with asking("rtu", places) as client:
        write(client, COMMAND + 1, [40, 0xFF00])
        write(client, COMMAND, [0x0900])
        eventually(lambda: status(client, 4) == (0xF900, 40, 40 << 8))


def asked(connection, line):
    """Return what a client takes for an answer that reads once."""
    connection.sendall(line.encode() + b"\n")
    return connection.recv(1024)


def test_variables_of_the_urcap_are_set_together_and_confirmed_without_an_end_of_line(served):
    _, places = served(UrcapStandIn)
    with connected(places["urcap"]) as connection:
        for line in ("SID 9", "ACT 0", "ATR 0", "ARD 1", "ADR 0", "ACT 1"):
            assert asked(connection, f"SET {line}") == b"ack"
        eventually(lambda: asked(connection, "GET STA") == b"STA 3\n")
        assert asked(connection, "SET POS 120 SPE 255 FOR 7 GTO 1") == b"ack"
        for last in ("PRE 120", "OBJ 3"):  # before the echo OBJ is of the command before
            eventually(lambda: asked(connection, f"GET {last[:3]}") == f"{last}\n".encode())  # noqa: B023
        told = {
            "ACT": 1,
            "GTO": 1,
            "ATR": 0,
            "ARD": 0,
            "ADR": 0,
            "FOR": 7,
            "SPE": 255,
            "PRE": 120,
            "POS": 120,
            "FLT": 0,
            "SID": 9,
        }
        for name, value in told.items():
            assert asked(connection, f"GET {name}") == f"{name} {value}\n".encode()


@pytest.mark.parametrize("asked_before", range(QUESTIONS))
def test_the_end_of_the_motion_before_is_never_taken_for_the_end_of_this_one(asked_before):
    """Whenever the URCap asks the gripper between the command and an answer; the fingers stand, as by their clock."""
    clock = [0.0]
    stand_in = UrcapStandIn("127.0.0.1", StandInWorld(now=lambda: clock[0]), {"urcap": 0})
    stand_in.activated()
    host, _, port = stand_in.start()["urcap"].partition(":")
    wire = UrcapWire(host, int(port), PATIENCE)
    wire.go(100, 255, 255)
    clock[0] += 5.0
    assert (wire.read().echo, wire.read().found) == (100, ObjectStatus.ARRIVED)
    for _ in range(asked_before):
        stand_in._reply("GET POS")
    wire.go(200, 255, 255)
    said = [wire.read() for _ in range(3)]
    wire.close()
    stand_in.stop()
    assert all(one.found is ObjectStatus.MOVING for one in said if one.echo == 200)
    assert said[-1].echo == 200


def test_variables_that_are_asked_for_together_are_answered_together(served):
    _, places = served(UrcapStandIn)
    with connected(places["urcap"]) as connection:
        assert asked(connection, "GET ACT\nGET STA\nGET FLT") == b"ACT 0\nSTA 0\nFLT 0\n"


@pytest.mark.parametrize("line", ["GET XYZ", "SET XYZ 1", "SET POS 256", "SET STA 1", "SET POS", "HELLO", ""])
def test_what_the_urcap_does_not_know_is_answered_by_a_question_mark(served, line):
    stand_in, places = served(UrcapStandIn)
    with connected(places["urcap"]) as connection:
        assert asked(connection, line) == b"?\n"
    assert stand_in.state()["writes"] == 0


@pytest.mark.parametrize("ack", [b"ack", b"ack\n", b"ack\r\n"])
def test_our_own_client_takes_a_confirmation_with_and_without_an_end_of_line(served, monkeypatch, ack):
    stand_in, places = served(UrcapStandIn)
    monkeypatch.setattr(stand_in, "_set", lambda values: ack.decode())
    host, _, port = places["urcap"].partition(":")
    wire = UrcapWire(host, int(port), PATIENCE)
    for _ in range(3):
        wire.go(100, 255, 255)
        assert wire.read().position == stand_in.model.read().position
    wire.close()
