"""Clients of a force sensor as others write them: the stream, the commands over TCP, and the page that gives the size of a count."""

import http.client
import socket
import struct
import xml.etree.ElementTree as ET
from contextlib import contextmanager

import pytest
from waiting import eventually

from stretch_bt.frames import Wrench
from stretch_bt.hardware.emulators.ati import AtiStandIn
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

PATIENCE = 10.0
RECORD = struct.Struct(">3I6i")
STOP, STREAM, BUFFERED, BIAS = 0, 2, 3, 0x42
LOAD = {"fx": 3.0, "fy": -2.0, "fz": 40.0}
#: of noise, N
NEAR = 0.05


class Still(StandInWorld):
    """A stage that presses on nothing."""

    def wrench(self, kind):
        return Wrench((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.fixture
def sensor():
    made = AtiStandIn("127.0.0.1", Still(), dict.fromkeys(AtiStandIn.PORTS, 0))
    made.places = made.start()
    made.inject("load", LOAD)
    yield made
    made.stop()


def address(place):
    host, _, port = place.partition(":")
    return host, int(port)


@contextmanager
def streaming(sensor):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(PATIENCE)
        client.connect(address(sensor.places["rdt"]))
        yield client
        client.send(struct.pack(">HHI", 0x1234, STOP, 0))


def records(packet):
    return [RECORD.unpack(packet[k : k + RECORD.size]) for k in range(0, len(packet), RECORD.size)]


def ask(client, command, count=0):
    client.send(struct.pack(">HHI", 0x1234, command, count))


def forces(record):
    return [count / 1e6 for count in record[3:6]]


@pytest.mark.parametrize("count", [1, 7])
def test_as_many_records_come_as_were_asked_for(sensor, count):
    with streaming(sensor) as client:
        for _ in range(2):
            ask(client, STREAM, count)
            came = [records(client.recv(1024)) for _ in range(count)]
            assert [[record[0] for record in packet] for packet in came] == [[k + 1] for k in range(count)]
            assert forces(came[0][0]) == pytest.approx(list(LOAD.values()), abs=NEAR)
            eventually(lambda: not sensor.state()["streaming"])


def test_a_buffered_stream_has_more_than_one_record_a_packet(sensor):
    with streaming(sensor) as client:
        ask(client, BUFFERED, 24)
        came = [records(client.recv(2048)) for _ in range(3)]
        assert [len(packet) for packet in came] == [10, 10, 4]
        assert [record[0] for packet in came for record in packet] == list(range(1, 25))


def test_a_bias_and_a_stop(sensor):
    with streaming(sensor) as client:
        ask(client, BIAS)
        ask(client, STREAM)
        assert forces(records(client.recv(1024))[0]) == pytest.approx([0.0] * 3, abs=NEAR)
        ask(client, STOP)
        eventually(lambda: not sensor.state()["streaming"])


def commanded(client, number, system=0, size=16):
    """Return the answer to a command of 20 bytes."""
    client.sendall(bytes([number]) + bytes(17) + struct.pack(">H", system))
    answer = b""
    while len(answer) < size:
        answer += client.recv(size - len(answer))
    return answer


def test_commands_read_forces_and_what_they_count(sensor):
    with socket.create_connection(address(sensor.places["commands"]), timeout=PATIENCE) as client:
        header, newton, newton_metre, per_force, per_torque, *scales = struct.unpack(
            ">H2B2I6H", commanded(client, 1, size=24)
        )
        assert (header, newton, newton_metre, per_force, per_torque) == (0x1234, 2, 3, 1_000_000, 1_000_000)
        header, status, *counts = struct.unpack(">2H6h", commanded(client, 0))
        assert (header, status) == (0x1234, 0)
        felt = [count * scale / per_force for count, scale in zip(counts, scales, strict=True)]
        assert felt == pytest.approx([*LOAD.values(), 0.0, 0.0, 0.0], abs=NEAR)
        _, _, *counts = struct.unpack(">2H6h", commanded(client, 0, system=1))
        assert [count * scales[0] / per_force for count in counts[:3]] == pytest.approx([0.0] * 3, abs=NEAR)
        sensor.inject("status", {"code": 0x80000002})
        assert commanded(client, 0)[2:4] == b"\x80\x00"


def fetched(sensor, path):
    connection = http.client.HTTPConnection(*address(sensor.places["page"]), timeout=PATIENCE)
    connection.request("GET", path)
    answer = connection.getresponse()
    return answer.status, answer.read()


@pytest.mark.parametrize("path", ["/netftapi2.xml", "/netftapi2.xml?index=0"])
def test_the_page_says_what_a_count_is(sensor, path):
    status, body = fetched(sensor, path)
    page = ET.fromstring(body)
    assert (status, page.tag) == (200, "netft")
    assert {name: page.findtext(name) for name in ("cfgcpf", "cfgcpt", "scfgfu", "scfgtu", "runstat")} == {
        "cfgcpf": "1000000",
        "cfgcpt": "1000000",
        "scfgfu": "N",
        "scfgtu": "Nm",
        "runstat": "0x00000000",
    }


@pytest.mark.parametrize("path", ["/", "/netftapi.xml"])
def test_other_pages_are_not_there(sensor, path):
    assert fetched(sensor, path) == (404, b"")


def test_stand_ins_whose_stream_has_a_free_port_stand_beside_each_other(sensor):
    beside = AtiStandIn("127.0.0.1", Still(), {"rdt": 0})
    try:
        places = beside.start()
        assert all(
            places[name] != place for name, place in sensor.places.items()
        )  # UDP may have the number of a TCP port
    finally:
        beside.stop()


def test_a_sensor_that_is_silent_answers_nobody(sensor):
    sensor.inject("silence")
    with socket.create_connection(address(sensor.places["commands"]), timeout=PATIENCE) as client:
        client.sendall(bytes(20))
        with pytest.raises(http.client.RemoteDisconnected):
            fetched(sensor, "/netftapi2.xml")
        sensor.clear("silence")
        assert commanded(client, 0)[:2] == b"\x12\x34"
