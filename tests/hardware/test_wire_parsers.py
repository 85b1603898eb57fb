"""What is read off the wires: anything may come, and nothing crashes, hangs or moves."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.ati.rdt import Ask, Record, parse_request, request, status_text
from stretch_bt.hardware.ati.stream import Stream
from stretch_bt.hardware.emulators.control import ControlPort
from stretch_bt.hardware.emulators.gripper_model import GripperModel
from stretch_bt.hardware.emulators.modbus import RtuFraming, TcpFraming, answer, crc16
from stretch_bt.hardware.emulators.robotiq import RobotiqStandIn
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import TcpServer
from stretch_bt.hardware.emulators.urcap import UrcapStandIn, parse_line
from stretch_bt.hardware.robotiq.calibration import GripperCalibration
from stretch_bt.hardware.robotiq.modbus_wire import ModbusWire, tcp_client
from stretch_bt.hardware.robotiq.registers import FAULTS, Command, ObjectStatus, Status, fault_of
from stretch_bt.hardware.robotiq.registers import ActivationStage as Activation
from stretch_bt.hardware.robotiq.urcap_wire import UrcapWire, parse_value
from stretch_bt.hardware.wire_thread import WireError

WORD = st.integers(0, 0xFFFFFFFF)
COUNT = st.integers(-(1 << 31), (1 << 31) - 1)
RECORDS = st.builds(Record, WORD, WORD, WORD, st.tuples(*[COUNT] * 6))

# frames of the manual
GOLDEN = {
    "activate": "09 10 03 E8 00 03 06 01 00 00 00 00 00 72 E1",
    "clear": "09 10 03 E8 00 03 06 00 00 00 00 00 00 73 30",
    "close": "09 10 03 E8 00 03 06 09 00 00 FF FF FF 42 29",
    "read by 4": "09 04 07 D0 00 03 B1 CE",
    "read by 3": "09 03 07 D0 00 03 04 0E",
}
#: frames whose length is to be found out: of one register, of two blocks, and of a function that is not known
OTHERS = ["09 06 03 E8 01 00", "09 17 07 D0 00 03 03 E8 00 01 02 01 00", "09 2B 0E 01 00"]
REPLIES = {
    "09 04 06 F9 00 00 00 0D 00 17 AA": Status(True, True, Activation.ACTIVE, ObjectStatus.ARRIVED, 0, 0, 13),
    "09 04 06 B9 00 00 FF BD 00 5C 9A": Status(True, True, Activation.ACTIVE, ObjectStatus.WHILE_CLOSING, 0, 255, 189),
}


class Memory:
    """Registers that take and give anything in their range."""

    def __init__(self):
        self.written = []

    def read(self, function, start, count):
        return [start & 0xFFFF] * min(count, 125)

    def write(self, start, values):
        self.written.append((start, values))


@pytest.mark.parametrize("name", GOLDEN)
def test_the_frames_of_the_manual_are_understood_whole_and_in_pieces(name):
    data = bytes.fromhex(GOLDEN[name])
    assert crc16(data[:-2]) == int.from_bytes(data[-2:], "little")
    framing = RtuFraming()
    found = [r for byte in data for r in framing.requests(bytes([byte]))]
    assert [(r.unit, r.pdu) for r in found] == [(9, data[1:-2])]


@pytest.mark.parametrize("text", OTHERS)
def test_frames_of_other_functions_are_understood(text):
    data = bytes.fromhex(text)
    framed = data + crc16(data).to_bytes(2, "little")
    framing = RtuFraming()
    assert [(r.unit, r.pdu) for r in framing.requests(framed[:3])] == []
    assert [(r.unit, r.pdu) for r in framing.requests(framed[3:])] == [(9, data[1:])]


@pytest.mark.parametrize("text", REPLIES)
def test_the_answers_of_the_manual_are_read_and_written(text):
    data = bytes.fromhex(text)
    registers = [int.from_bytes(data[k : k + 2], "big") for k in (3, 5, 7)]
    assert Status.decode(registers) == REPLIES[text]
    assert REPLIES[text].encode() == registers


def test_the_command_of_the_manual():
    assert Command(activate=True, go=True, position=255, speed=255, force=255).encode() == [0x0900, 0x00FF, 0xFFFF]
    assert Command(activate=True).encode() == [0x0100, 0, 0]


@given(st.lists(st.one_of(st.integers(0, 0xFFFF), st.integers(), st.none()), max_size=5))
def test_any_registers_are_a_status_or_refused(registers):
    try:
        status = Status.decode(registers)
    except InvalidInput:
        assert len(registers) != 3 or any(r is None or not 0 <= r <= 0xFFFF for r in registers)
    else:
        assert 0 <= status.position <= 255
        assert status.ready == (registers[0] >> 8 & 0x31 == 0x31)
        assert fault_of(status.fault).remedy


@given(
    st.builds(
        Command,
        st.booleans(),
        st.booleans(),
        st.integers(0, 255),
        st.integers(0, 255),
        st.integers(0, 255),
        st.booleans(),
        st.booleans(),
    )
)
def test_commands_survive_the_wire(command):
    assert Command.decode(command.encode()) == command


@pytest.mark.parametrize("name", ["position", "speed", "force"])
@pytest.mark.parametrize("count", [-1, 256])
def test_counts_out_of_range_are_not_sent(name, count):
    with pytest.raises(InvalidInput, match=f"{name} is a count"):
        Command(activate=True, **{name: count}).encode()


@given(st.binary(max_size=64), st.text(alphabet="ACTGOPSFLR", min_size=3, max_size=3))
def test_any_line_of_the_urcap_is_a_value_or_refused(line, name):
    try:
        value = parse_value(line, name)
    except WireError as error:
        assert len(str(error)) < 250
    else:
        assert line.strip().replace(b" ", b"") in {f"{name}{value:0{k}d}".encode() for k in (1, 2, 3)}


@given(st.integers(0, 255))
def test_values_of_the_urcap(value):
    assert parse_value(f"POS {value}\n".encode(), "POS") == value
    with pytest.raises(WireError, match="GET PRE"):
        parse_value(f"POS {value}".encode(), "PRE")


@given(st.binary(max_size=60))
def test_any_packet_is_a_record_or_refused(data):
    if len(data) == 36:
        assert Record.decode(data).encode() == data
    else:
        with pytest.raises(InvalidInput, match="36 bytes"):
            Record.decode(data)
    parse_request(data)


@given(RECORDS)
def test_records_survive_the_wire(record):
    assert Record.decode(record.encode()) == record
    assert "bit" in status_text(record.status)


@given(WORD)
def test_requests(count):
    assert parse_request(request(Ask.STREAM, count)) == (2, count)
    assert parse_request(b"\x12\x35" + request(Ask.STREAM)[2:]) is None


@given(st.lists(RECORDS, max_size=40))
def test_any_stream_keeps_count(records):
    stream = Stream()
    taken = sum(stream.take(record) for record in records)
    c = stream.counters
    assert c.received == len(records)
    assert taken <= len(records)
    assert min(c.lost, c.late, c.repeated, c.stale) >= 0
    assert (stream.newest is None) == (not records)


@given(st.permutations(range(1, 30)), st.integers(0, (1 << 32) - 1))
def test_a_stream_in_any_order_gives_rising_numbers_only(order, first):
    """Also where the number turns to 0."""
    stream = Stream()
    numbers = []
    for k in order:
        if stream.take(Record((first + k) % (1 << 32), k, 0, (0,) * 6)):
            numbers.append(k)
    assert numbers == sorted(numbers)
    assert stream.counters.late == len(order) - len(numbers)


@given(st.lists(st.binary(max_size=30), max_size=8))
@pytest.mark.parametrize("framing", [RtuFraming, TcpFraming])
def test_any_bytes_on_a_modbus_line(framing, chunks):
    memory, cut = Memory(), framing()
    for chunk in chunks:
        for found in cut.requests(chunk):
            assert len(found.frame(answer(found.pdu, memory))) < 300


@given(st.binary(max_size=40))
def test_any_request_is_answered(pdu):
    memory = Memory()
    reply = answer(pdu, memory)
    assert reply[0] & 0x7F == (pdu[0] & 0x7F if pdu else 0)
    if memory.written:
        assert pdu[0] in (6, 16, 23)


# (request without its frame, its answer)
EXCEPTIONS = [
    ("04 07 CF 00 03", "84 02"),
    ("04 07 D0 00 04", "84 02"),
    ("04 03 E8 00 03", "84 02"),
    ("03 03 E8 00 04", "83 02"),
    ("03 07 D0 00 00", "83 03"),
    ("03 07 D0 00 7E", "83 03"),
    ("10 03 E8 00 04 08 09 00 00 00 00 00 00 00", "90 02"),
    ("10 07 D0 00 03 06 09 00 00 00 00 00", "90 02"),
    ("10 03 E8 00 03 05 09 00 00 00 00", "90 03"),
    ("10 03 E8 00 00 00", "90 03"),
    ("06 07 D0 09 00", "86 02"),
    ("06 03 E8 09", "86 03"),
    ("17 07 D0 00 03 07 D0 00 01 02 01 00", "97 02"),
    ("17 07 D0 00 04 03 E8 00 01 02 01 00", "97 02"),
    ("17 07 D0 00 03 03 E8 00 01 04 01 00", "97 03"),
    ("17 07 D0", "97 03"),
    ("04 07 D0", "84 03"),
    ("01 00 00 00 01", "81 01"),
    ("2B 0E 01 00", "AB 01"),
]


@pytest.mark.parametrize(("asked", "reply"), EXCEPTIONS)
def test_what_the_gripper_does_not_have_is_answered_by_an_exception(asked, reply):
    stand_in = RobotiqStandIn("127.0.0.1", StandInWorld())
    assert answer(bytes.fromhex(asked), stand_in._registers) == bytes.fromhex(reply)
    assert stand_in.state()["writes"] == 0


# (what is written before, request without its frame, its answer): the registers that are not written stay
ANSWERED = [
    ("", "06 03 E8 01 00", "06 03 E8 01 00"),
    ("10 03 E8 00 01 02 01 00", "03 03 E8 00 03", "03 06 01 00 00 00 00 00"),
    ("06 03 E9 00 FF", "03 03 E8 00 03", "03 06 00 00 00 FF 00 00"),
    ("10 03 E9 00 02 04 00 80 FF 10", "03 03 EA 00 01", "03 02 FF 10"),
    ("", "17 07 D0 00 01 03 E8 00 01 02 01 00", "17 02 11 00"),
    ("17 03 E8 00 01 03 EA 00 01 02 20 30", "03 03 E8 00 03", "03 06 00 00 00 00 20 30"),
]


@pytest.mark.parametrize(("before", "asked", "reply"), ANSWERED)
def test_registers_are_written_one_by_one_and_read_back(before, asked, reply):
    stand_in = RobotiqStandIn("127.0.0.1", StandInWorld(now=lambda: 0.0))
    if before:
        assert answer(bytes.fromhex(before), stand_in._registers)[0] < 0x80
    assert answer(bytes.fromhex(asked), stand_in._registers) == bytes.fromhex(reply)


@given(st.lists(st.binary(max_size=40), max_size=6))
def test_no_bytes_but_a_command_move_the_fingers(chunks):
    """Whatever comes, an inactive gripper stays where it is."""
    time = [0.0]
    stand_in = RobotiqStandIn("127.0.0.1", StandInWorld(now=lambda: time[0]))
    rtu, tcp = RtuFraming(), TcpFraming()
    for chunk in chunks:
        for framing in (rtu, tcp):
            for found in framing.requests(chunk):
                stand_in._reply(found)
        time[0] += 1.0
    assert stand_in.stage.opening() == 0.055


@given(
    st.one_of(
        st.text(max_size=40),
        st.lists(st.sampled_from(["GET", "SET", "ACT", "GTO", "POS", "0", "1", "255", "256", "FLT"])).map(" ".join),
    )
)
def test_any_line_to_the_urcap(line):
    stand_in = UrcapStandIn("127.0.0.1", StandInWorld(now=lambda: 0.0))
    reply = stand_in._reply(line)
    assert reply == "?\n" or parse_line(line) is not None
    assert not stand_in.state()["moving"] or "ACT" in line


@given(st.lists(st.tuples(st.booleans(), st.booleans(), *[st.integers(0, 255)] * 3, st.floats(0.0, 3.0)), max_size=12))
def test_any_commands_leave_the_fingers_between_their_ends(commands):
    time = [0.0]
    model = GripperModel(StandInWorld(now=lambda: time[0]), lambda _: None)
    for activate, go, position, speed, force, passed in commands:
        model.write(Command(activate, go, position, speed, force))
        time[0] += passed
        status = model.read()
        assert Status.decode(status.encode()) == status
        assert 3 <= status.position <= 230
        assert status.fault in {0, *FAULTS}


VERBS = st.sampled_from(["list", "inject", "clear", "renew", "robotiq", "slow", "code"])
KEYS = st.sampled_from(["do", "device", "fault", "times", "delay"])
JSON = st.one_of(
    st.recursive(st.none() | st.text(max_size=8) | st.integers(), st.lists),
    st.dictionaries(KEYS, st.one_of(VERBS, st.floats(), st.none(), st.booleans())),
).map(lambda value: json.dumps(value).encode())


@given(line=st.one_of(st.binary(max_size=80), JSON))
def test_any_line_to_the_control_port_is_answered(line, control_port):
    reply = control_port.answer(line)
    assert reply["ok"] or reply["error"]
    json.dumps(reply)


@pytest.fixture(scope="module")
def control_port():
    port = ControlPort(
        ("127.0.0.1", 0),
        {"robotiq": RobotiqStandIn("127.0.0.1", StandInWorld())},
        {"robotiq": {"rtu": "nowhere"}},
        renew=lambda: None,
    )
    yield port
    port.stop()


WIRES = {
    "urcap": lambda host, port: UrcapWire(host, port, 0.03),
    "rtu": lambda host, port: ModbusWire(lambda: tcp_client(host, port, "rtu", 0.03), 9),
    "tcp": lambda host, port: ModbusWire(lambda: tcp_client(host, port, "tcp", 0.03), 9),
}
ALMOST = [bytes.fromhex(text) for text in REPLIES] + [b"ACT 1\nGTO 1\n", b"\0\1\0\0\0\3\x09\x84\2", b"\0\1\0\0\0\0\0"]


@settings(max_examples=15)
@given(said=st.one_of(st.binary(min_size=1, max_size=300), st.sampled_from(ALMOST)), again=st.booleans())
@pytest.mark.parametrize("kind", WIRES)
def test_a_peer_that_says_anything_is_read_within_its_time(kind, said, again):
    """It is a status, or the wire gives up; a thread that reads is never left."""

    def serve(connection):
        while connection.recv(100):
            connection.sendall(said)
            if not again:
                return

    server = TcpServer("127.0.0.1", 0, serve)
    try:
        wire = WIRES[kind](*server.address)
        try:
            assert isinstance(wire.read(), Status)
        except WireError as error:
            assert str(error)
        wire.close()
    finally:
        server.stop()


# (points, part of what is said)
BAD_CALIBRATIONS = [
    ([(3, "140 mm")], "at least 2"),
    ([(3, "140 mm"), (3, "0 mm")], "must fall"),
    ([(3, "0 mm"), (230, "140 mm")], "must fall"),
    ([(3, "140 mm"), (256, "0 mm")], "out of bounds"),
]


@pytest.mark.parametrize(("points", "said"), BAD_CALIBRATIONS)
def test_a_calibration_that_cannot_be(points, said):
    with pytest.raises(ValueError, match=said):
        calibration(points)


def calibration(points):
    made = [{"count": count, "opening": opening} for count, opening in points]
    return GripperCalibration.model_validate({"points": made, "source": "a test"})


@given(st.integers(0, 255))
def test_a_calibration_and_its_inverse(count):
    made = calibration([(230, "2 mm"), (3, "140 mm"), (100, "90 mm")])
    opening = made.opening(count)
    if 3 <= count <= 230:
        assert made.count(opening) == count
    else:
        with pytest.raises(InvalidInput, match="was not calibrated, but 2 mm to 140 mm"):
            made.count(opening)
    assert made.opening(3) == pytest.approx(0.140)
    assert made.opening(100) == pytest.approx(0.090)
