"""The ports 30001 to 30003 and 30011 to 30013, by clients that share no code with them."""

import itertools
import socket
import struct
import time

import pytest
from ur_wires import RtdeClient, Wire, messages, states

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.client_port import sent
from stretch_bt.hardware.emulators.ur.script_reader import ScriptReader
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.transforms import six

STATE_PORTS = (30001, 30002, 30011, 30012)


@pytest.fixture(scope="module", params=[Ur5StandIn, Ur5eStandIn])
def behind(request, own_hosts):
    """A stand-in."""
    made = request.param(next(own_hosts), StandInWorld())
    made.start()
    yield made
    made.stop()


@pytest.mark.parametrize("port", STATE_PORTS)
def test_a_client_is_told_the_version_first_and_then_the_state(behind, port):
    with Wire(behind.host, port) as wire:
        told = messages(wire)
        kind, body = next(told)
        stamp, _, message, length = struct.unpack_from(">QbbB", body)
        assert (kind, message, body[11 : 11 + length]) == (20, 3, b"URControl")
        assert struct.unpack_from(">BBii", body, 11 + length) == behind.PROFILE.version
        first, second = itertools.islice(states(wire), 2)
    times = [struct.unpack_from(">Q", state[0])[0] for state in (first, second)]
    assert times[0] >= stamp
    assert times[1] - times[0] == pytest.approx(1e5, abs=1e6 / behind.PROFILE.rate)


def test_the_parts_of_a_state_are_those_of_the_guide(behind):
    with Wire(behind.host, 30002) as wire:
        state = next(states(wire))
    sizes = {0: 41, 1: 246, 2: 32, 3: 70, 4: 96, 5: 220, 6: 440, 7: 56, 8: 3, 9: 48}
    if behind.PROFILE.e_series:
        sizes |= {0: 42, 8: 4, 11: 21, 12: 3}
    assert {kind: len(part) for kind, part in state.items()} == sizes
    flags = struct.unpack_from(">7?B", state[0], 8)
    assert flags == (True, True, True, False, False, False, False, 7)
    joints = [struct.unpack_from(">dd", state[1], 41 * k) for k in range(6)]
    assert joints == [(q, q) for q in behind.arm.q]
    assert struct.unpack(">6d", state[4][:48]) == pytest.approx(six(behind.arm.pose()))
    lengths = struct.unpack_from(">12d", state[5], 24 + 48)
    assert lengths == (*behind.arm.kinematics.a, *behind.arm.kinematics.d)


@pytest.mark.parametrize("port", [30003, 30013])
def test_a_packet_comes_in_each_cycle(behind, port):
    size = 1220 if behind.PROFILE.e_series else 1116
    with Wire(behind.host, port) as wire:
        packets = []
        for _ in range(10):
            assert struct.unpack(">i", wire.read(4)) == (size,)
            packets.append(struct.unpack(f">{size // 8}d", wire.read(size - 4)))
    times = [packet[0] for packet in packets]
    steps = [b - a for a, b in itertools.pairwise(times)]
    assert steps == pytest.approx([1 / behind.PROFILE.rate] * 9, abs=1e-9)
    last = packets[-1]
    assert last[1:7] == last[31:37] == tuple(behind.arm.q)
    assert last[55:61] == pytest.approx(six(behind.arm.pose()))
    assert (last[94], last[101], last[131], last[138]) == (7, 1, 1, 1)


def test_a_client_that_does_not_read_disturbs_nobody(behind):
    with Wire(behind.host, 30003), RtdeClient(behind.host, 2) as other:
        other.outputs(["timestamp"], behind.PROFILE.rate)
        other.start()
        times = [other.values()[0] for _ in range(200)]
    assert max(b - a for a, b in itertools.pairwise(times)) < 1.5 / behind.PROFILE.rate


def test_a_full_connection_is_not_waited_for():
    one, other = socket.socketpair()
    with one, other:
        one.settimeout(30.0)
        begun, rest = time.monotonic(), b"x" * (1 << 23)
        for _ in range(50):
            rest = sent(one, rest)
        assert rest
        assert time.monotonic() - begun < 20.0


def test_nothing_is_made_where_nobody_listens(monkeypatch):
    stand_in = Ur5StandIn("127.0.0.1", StandInWorld(), dict.fromkeys(Ur5StandIn.PORTS, 0))
    monkeypatch.setattr("stretch_bt.hardware.emulators.ur.stand_in.robot_state", lambda c: pytest.fail("made"))
    monkeypatch.setattr("stretch_bt.hardware.emulators.ur.stand_in.realtime_packet", lambda c: pytest.fail("made"))
    stand_in.start()
    ports = list(stand_in._clients.values())
    stand_in.stop()
    for port in ports * 20:
        port.tell()


PROGRAMS = {
    "one line": ["movej([0,0,0,0,0,0])\n"],
    "a block": ["def f():\n  if True:\n    sleep(1)\n  end\nend # of f\n"],
    "both": ["sec g():\n set_digital_out(0, True)\nend\n", "stopj(2)\n"],
    "threads": ["def f():\nthread t():\n while True:\n sync()\nend\nend\n for i in x:\n end\nend\n"],
}


@pytest.mark.parametrize("programs", PROGRAMS.values(), ids=PROGRAMS)
@pytest.mark.parametrize("piece", [1, 7, 1000])
def test_programs_are_found_however_they_come(programs, piece):
    data = ("# a comment\n\n" + "\n".join(programs)).encode()
    reader = ScriptReader()
    assert [p for k in range(0, len(data), piece) for p in reader.feed(data[k : k + piece])] == programs


def test_a_program_without_an_end_is_given_up():
    reader = ScriptReader()
    line = b"  x = 1" + b" " * 1000 + b"\n"
    assert list(reader.feed(b"def f():\n" + line * 1100)) == []
    assert list(reader.feed(b"")) == []
    assert list(reader.feed(b"stopj(2)\n")) == ["stopj(2)\n"]
