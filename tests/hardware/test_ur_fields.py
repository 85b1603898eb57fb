"""All fields of RTDE over both versions of its protocol, by a client of its own."""

import math
import struct

import pytest
from ur_wires import LAYOUT, RtdeClient

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.fields import INPUT_FIELDS, OUTPUT_FIELDS, found
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.emulators.ur.variables import OUTPUTS
from stretch_bt.hardware.emulators.ur.wire import TYPES, pack

PROTOCOLS = (1, 2)


@pytest.fixture(scope="module", params=[Ur5StandIn, Ur5eStandIn])
def behind(request, own_hosts):
    """A stand-in."""
    made = request.param(next(own_hosts), StandInWorld())
    made.start()
    yield made
    made.stop()


@pytest.fixture(params=PROTOCOLS, ids=["first", "second"])
def client(request, behind):
    with RtdeClient(behind.host, request.param) as made:
        yield made


def test_every_field_has_a_value_of_its_type():
    controller = Ur5eStandIn("127.0.0.1", StandInWorld()).controller
    assert set(OUTPUTS) == set(OUTPUT_FIELDS)
    assert {field.kind for field in (OUTPUT_FIELDS | INPUT_FIELDS).values()} <= set(TYPES)
    for name, ask in OUTPUTS.items():
        kind = OUTPUT_FIELDS[name].kind
        assert len(pack([kind], [ask(controller)])) == struct.calcsize(">" + LAYOUT[kind]), name


def test_all_fields_of_the_controller_come_at_once(behind, client):
    names = [name for name in OUTPUT_FIELDS if found(OUTPUT_FIELDS, name, behind.PROFILE.version)]
    assert len(names) > 370
    assert client.outputs(names) == [OUTPUT_FIELDS[name].kind for name in names]
    assert client.start()
    told = dict(zip(names, client.values(), strict=True))
    assert told["actual_q"] == told["target_q"] == pytest.approx(behind.arm.q.tolist())
    assert (told["robot_mode"], told["safety_mode"], told["safety_status"], told["runtime_state"]) == (7, 1, 1, 1)
    assert (told["joint_mode"], told["tool_mode"]) == ((253,) * 6, 253)
    assert told["tcp_offset"] == (0.0,) * 6
    assert math.hypot(*told["actual_tool_accelerometer"]) == pytest.approx(9.82)
    assert told["elbow_position"][2] > 0.3
    assert told["timestamp"] < client.values()[names.index("timestamp")]


#: software without the field, and with it
NEWER = {
    "ft_raw_wrench": ((3, 15, 8), (5, 9, 0)),
    "payload_inertia": ((5, 10, 2), (5, 11, 0)),
    "elbow_position": ((3, 4, 5), (3, 5, 0)),
    "output_int_register_24": ((3, 8, 0), (3, 9, 0)),
    "time_scale_source": ((5, 11, 8), (5, 17, 0)),
}


@pytest.mark.parametrize("name", NEWER)
def test_a_field_is_not_in_older_software(name):
    older, newer = NEWER[name]
    assert found(OUTPUT_FIELDS, name, older) is None
    assert found(OUTPUT_FIELDS, name, newer) is not None


def test_what_is_not_there_is_named_and_not_started(client):
    assert client.outputs(["timestamp", "no_such_field", "time_scale_source"]) == ["DOUBLE", "NOT_FOUND", "NOT_FOUND"]
    assert not client.start()
    assert client.inputs(["input_int_register_40", "no_such_field"]) == (0, ["INT32", "NOT_FOUND"])


def test_registers_of_several_recipes_come_back(client):
    names = ["input_int_register_41", "input_double_register_41", "input_bit_register_70", "input_bit_registers0_to_31"]
    first, kinds = client.inputs(names[:2])
    second, more = client.inputs(names[2:])
    assert (second, kinds, more) == (first + 1, ["INT32", "DOUBLE"], ["BOOL", "UINT32"])
    client.outputs(names)
    assert client.start()
    sent = [-7 * client.protocol, 2.5 * client.protocol, client.protocol == 2, 0x81 * client.protocol]
    client.send("U", struct.pack(">Bid", first, *sent[:2]))
    client.send("U", struct.pack(">B?I", second, *sent[2:]))
    assert client.read_until(lambda values: values == sent) == sent
    assert client.pause()
    assert client.start()
    assert client.values() == sent


def test_an_analog_output_is_set_in_its_range(behind, client):
    recipe, _ = client.inputs([f"standard_analog_output_{name}" for name in ("mask", "type", "0", "1")])
    client.outputs(["standard_analog_output0", "standard_analog_output1", "analog_io_types"])
    client.start()
    client.send("U", struct.pack(">BBBdd", recipe, 3, 2, 0.5, 0.5))
    told = client.read_until(lambda values: values[1] > 1.0)
    assert told == [pytest.approx(0.012), pytest.approx(5.0), 0b1011]


def test_clients_do_not_take_each_others_inputs(behind):
    name = ["input_double_register_30"]
    with RtdeClient(behind.host, 1) as one, RtdeClient(behind.host, 2) as other:
        assert one.inputs(name) == (1, ["DOUBLE"])
        assert other.inputs(name) == (0, ["IN_USE"])
        for client in (one, other):
            client.outputs(["timestamp"])
            assert client.start()
        assert one.values()[0] > 0
        assert other.values()[0] > 0


def test_a_message_of_a_client_is_written_down(client, behind):
    words = f"hello by protocol {client.protocol}".encode()
    head, tail = (bytes([len(words)]), b"\x04self\x02") if client.protocol == 2 else (b"\x02", b"")
    client.send("M", head + words + tail)
    client.ask("v")
    assert any(event.endswith(f"a client says: {words.decode()}") for event in behind.state()["events"])


@pytest.mark.parametrize("asked", [b"\x00\x03", b"\x00\x00", b"\x02", b""])
def test_other_versions_of_the_protocol_are_refused(behind, asked):
    with RtdeClient(behind.host, 1) as client:
        assert client.ask("V", asked) == b"\x00"
        assert client.outputs(["timestamp"]) == ["DOUBLE"]


@pytest.mark.parametrize("rate", [5e-324, 1e-310, 125.0])
def test_any_rate_above_0_is_taken(behind, rate):
    with RtdeClient(behind.host, 2) as client:
        assert client.outputs(["timestamp"], rate) == ["DOUBLE"]
