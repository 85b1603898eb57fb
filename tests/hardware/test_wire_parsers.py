"""What is read off the wires: anything may come, and nothing crashes, hangs or moves."""

import json
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.hardware.ati.rdt import Ask, Record, parse_request, request, status_text
from stretch_bt.hardware.ati.stream import Stream
from stretch_bt.hardware.attendant import WireError
from stretch_bt.hardware.emulators.control import ControlPort
from stretch_bt.hardware.emulators.gripper_model import GripperModel
from stretch_bt.hardware.emulators.modbus import RtuFraming, TcpFraming, answer, crc16
from stretch_bt.hardware.emulators.robotiq import RobotiqStandIn
from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.emulators.tcp_server import TcpServer
from stretch_bt.hardware.emulators.urcap import UrcapStandIn, parse_line
from stretch_bt.hardware.realsense.judge import Judge, Shot
from stretch_bt.hardware.realsense.wire import Described, Packets, Picture, _packet
from stretch_bt.hardware.robotiq.calibration import GripperCalibration
from stretch_bt.hardware.robotiq.modbus_wire import ModbusWire, tcp_client
from stretch_bt.hardware.robotiq.registers import FAULTS, Command, Found, Status, fault_of
from stretch_bt.hardware.robotiq.registers import Stage as Activation
from stretch_bt.hardware.robotiq.urcap_wire import UrcapWire, parse_value

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
REPLIES = {
    "09 04 06 F9 00 00 00 0D 00 17 AA": Status(True, True, Activation.ACTIVE, Found.ARRIVED, 0, 0, 13),
    "09 04 06 B9 00 00 FF BD 00 5C 9A": Status(True, True, Activation.ACTIVE, Found.WHILE_CLOSING, 0, 255, 189),
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
        assert pdu[0] == 16


# (request without its frame, its answer)
EXCEPTIONS = [
    ("04 07 CF 00 03", "84 02"),
    ("04 07 D0 00 04", "84 02"),
    ("03 03 E8 00 03", "83 02"),
    ("03 07 D0 00 00", "83 02"),
    ("10 03 E8 00 02 04 09 00 00 00", "90 02"),
    ("10 07 D0 00 03 06 09 00 00 00 00 00", "90 02"),
    ("10 03 E8 00 03 05 09 00 00 00 00", "90 03"),
    ("06 03 E8 09 00", "86 01"),
    ("04 07 D0", "84 03"),
]


@pytest.mark.parametrize(("asked", "reply"), EXCEPTIONS)
def test_what_the_gripper_does_not_have_is_answered_by_an_exception(asked, reply):
    stand_in = RobotiqStandIn("127.0.0.1", Stage())
    assert answer(bytes.fromhex(asked), stand_in._registers) == bytes.fromhex(reply)
    assert stand_in.state()["writes"] == 0


@given(st.lists(st.binary(max_size=40), max_size=6))
def test_no_bytes_but_a_command_move_the_fingers(chunks):
    """Whatever comes, an inactive gripper stays where it is."""
    time = [0.0]
    stand_in = RobotiqStandIn("127.0.0.1", Stage(now=lambda: time[0]))
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
    stand_in = UrcapStandIn("127.0.0.1", Stage(now=lambda: 0.0))
    reply = stand_in._reply(line)
    assert reply is None or parse_line(line) is not None
    assert not stand_in.state()["moving"] or "ACT" in line


@given(st.lists(st.tuples(st.booleans(), st.booleans(), *[st.integers(0, 255)] * 3, st.floats(0.0, 3.0)), max_size=12))
def test_any_commands_leave_the_fingers_between_their_ends(commands):
    time = [0.0]
    model = GripperModel(Stage(now=lambda: time[0]), lambda _: None)
    for activate, go, position, speed, force, passed in commands:
        model.write(Command(activate, go, position, speed, force))
        time[0] += passed
        status = model.read()
        assert Status.decode(status.encode()) == status
        assert 3 <= status.position <= 230
        assert status.fault in {0, *FAULTS}


CAMERA = Described(serial="1", width=4, height=3, rate=30, unit=1e-4, fx=5.0, fy=5.0, cx=2.0, cy=1.5)
TIMES = st.floats(-1e11, 1e11)
PICTURES = st.builds(Picture, st.integers(0, (1 << 64) - 1), TIMES, st.binary(max_size=40))


def in_pieces(packets, data, sizes):
    """Yield what packets are cut out of bytes that come in pieces."""
    at = 0
    for size in [*sizes, len(data)]:
        yield from packets.feed(data[at : at + size])
        at += size


@given(st.lists(PICTURES, max_size=6), st.lists(st.integers(1, 60), max_size=20))
def test_frames_survive_the_wire_in_any_pieces(pictures, sizes):
    packets = Packets()
    data = b"".join(p.encode() for p in (CAMERA, *pictures))
    assert list(in_pieces(packets, data, sizes)) == [CAMERA, *pictures]
    assert packets.broken == 0


@given(st.lists(st.binary(max_size=60), max_size=8))
def test_any_bytes_are_no_frames(chunks):
    packets, found = Packets(), []
    try:
        for chunk in chunks:
            found += packets.feed(chunk)
    except InvalidInput as error:
        assert len(str(error)) < 200
    assert found == []


@given(st.lists(PICTURES, min_size=1, max_size=4), st.integers(0, 10_000), st.integers(1, 255))
def test_a_byte_that_is_changed_costs_its_frame_or_the_connection(pictures, at, change):
    """And never gives one that was not sent."""
    data = bytearray(b"".join(p.encode() for p in pictures))
    data[at % len(data)] ^= change
    found = []
    with suppress(InvalidInput):
        for packet in Packets().feed(bytes(data)):
            found.append(packet)
    assert all(packet in pictures for packet in found)
    assert len(found) <= len(pictures)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"{}", "Field required"),
        (CAMERA.model_dump_json().replace("0.0001", "NaN").encode(), "valid|finite"),
        (CAMERA.model_dump_json().replace('"width":4', '"width":0').encode(), "greater"),
        (CAMERA.model_dump_json().replace('"width":4', '"width":100000').encode(), "less"),
        (b"[" * 4000, "recursion|Invalid JSON|depth"),
    ],
)
def test_what_describes_no_camera(body, said):
    with pytest.raises(InvalidInput, match=said):
        list(Packets().feed(_packet(1, body)))


@given(st.integers(0, 255), st.binary(max_size=30))
def test_a_packet_of_any_kind(kind, body):
    try:
        found = list(Packets().feed(_packet(kind, body)))
    except InvalidInput:
        return
    assert kind == 2
    assert found[0].pixels == body[16:]


SHOTS = st.lists(
    st.tuples(st.integers(0, 12), st.integers(0, 12), st.floats(0.001, 0.5), st.integers(0, 3)), max_size=40
)


@given(SHOTS, st.booleans())
def test_any_frames_are_given_out_once_and_in_their_order(shots, noisy):
    """With their exposure never after they came, and every frame counted; a camera that is restarted may begin anew."""
    judge, now, taken, events = Judge(0.4, noisy, 0.0), 0.0, [], 0
    for number, time, wait, seed in shots:
        now += wait
        image = np.random.default_rng(seed).integers(0, 3, (48, 64)).astype(np.uint16) * (seed > 0)
        good = judge.take(Shot(number, time / 10, now, image))
        events, judge.event = events + (judge.event is not None), None
        assert (good is None) == (judge.bad is not None)
        if good is not None:
            assert good.exposed <= good.arrived == now
            assert judge.silent(now) == 0.0
            taken.append((good.number, good.time))
    assert judge.counters.received == len(shots)
    assert min(judge.counters.to_message().values()) >= 0
    if not events:
        assert taken == sorted(set(taken))


def test_noise_that_stands_in_a_strip_is_a_torn_image():
    random = np.random.default_rng(0)
    first, second = (random.integers(1590, 1610, (480, 640)).astype(np.uint16) for _ in range(2))
    judge = Judge(1.0, noisy=True, began=0.0)
    assert judge.take(Shot(1, 0.0, 0.0, first)) is not None
    torn = second.copy()
    torn[450:] = first[450:]
    assert judge.take(Shot(2, 0.03, 0.03, torn)) is None
    assert judge.bad == "its images are torn"
    cut = random.permuted(second, axis=1)
    cut[240:] = 0
    assert judge.take(Shot(3, 0.07, 0.07, cut)) is None
    assert judge.take(Shot(4, 0.1, 0.1, second)) is not None
    assert judge.counters.torn == 2
    still = Judge(1.0, noisy=False, began=0.0)
    assert [still.take(Shot(k, k / 30, k / 30, first)) is not None for k in range(3)] == [True] * 3


def test_a_frame_that_was_held_up_is_as_old_as_its_exposure():
    judge, random = Judge(10.0, noisy=False, began=0.0), np.random.default_rng(0)
    image = random.integers(1, 9, (4, 4)).astype(np.uint16)
    way = [0.02, 0.03, 0.02, 0.32, 0.29, 0.02]
    for k, late in enumerate(way):
        shot = judge.take(Shot(k, 50.0 + k, k + late, image))
        assert shot.exposed == pytest.approx(k + 0.02, abs=1e-3)  # the drift that a clock may have
    assert judge.event is None
    judge.take(Shot(9, 70.0, 10.0, image))
    assert "jumped ahead by 1" in judge.event


VERBS = st.sampled_from(["list", "inject", "clear", "robotiq", "slow", "code"])
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
        ("127.0.0.1", 0), {"robotiq": RobotiqStandIn("127.0.0.1", Stage())}, {"robotiq": {"rtu": "nowhere"}}
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
