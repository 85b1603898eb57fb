"""The force sensor on its stand-in: faults of the stream, zero, mounting."""

import itertools
import math
import time

import pytest

from stretch_bt.errors import DeviceFault, DeviceLost, StaleReading
from stretch_bt.hardware.ati.delay import Delay
from stretch_bt.hardware.ati.receiver import Receiver
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.ati import AtiStandIn
from stretch_bt.hardware.interfaces import DeviceState

LIMIT = 20.0

# (fault, parameters, kind of the fault, what it says)
ENDS = [
    ("silence", {}, DeviceLost, "no measurement for .*: nothing came; check its supply"),
    ("freeze", {}, DeviceLost, "measures nothing new"),
    ("short", {}, DeviceLost, "sends, but no records .*36 bytes, not 18.*check that this is the sensor"),
    ("status", {}, DeviceFault, r"status 80000002: supply voltage out of range \(bit 1\)"),
    ("status", {"code": 1 << 31}, DeviceFault, r"status 80000000: error \(bit 31\)"),
    ("status", {"code": 1 << 30 | 1 << 31, "times": 1}, DeviceFault, r"force or torque out of range \(bit 30\)"),
    ("status", {"code": 1 << 17 | 1 << 31}, DeviceFault, r"not in the manual of the Axia \(bit 17\)"),
    (
        "status",
        {"code": 1 << 16 | 1 << 31},
        DeviceFault,
        r"of a Net F/T: a monitor condition that is latched \(bit 16\)",
    ),
    ("restart", {}, DeviceFault, "the sensor was restarted"),
    ("noise", {}, DeviceFault, "status|restarted|jump"),
    ("frozen_force", {}, DeviceFault, "six values have been the same for"),
    ("wild", {"part": 1.0}, DeviceFault, "jump by more than"),
]
# (fault, parameters, the counter that shows it)
HARMLESS = [
    ("loss", {"part": 0.4}, "lost"),
    ("reorder", {"part": 0.4}, "late"),
    ("repeat", {}, "repeated"),
    ("freeze", {"times": 8}, "stale"),
    ("short", {"times": 5}, "malformed"),
    ("wild", {"part": 0.1}, "wild"),
]
OTHERS = {"load", "drift", "slow", "late"}


@pytest.fixture
def sensor(make_cell):
    """Return the sensor, its stand-in, and what waits for a number of new readings."""
    cell = make_cell("ati", lost_after="400 ms")
    return cell.devices["force_sensor"], cell.stand_in


def until(ask):
    """Return the first answer of `ask` that is true."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        if answer := ask():
            return answer
        time.sleep(0.005)
    raise AssertionError("it does not come")


def told(sensor, age=1e9):
    """Return the fault that a reading raises, if any."""
    try:
        sensor.wrench(age)
    except DeviceFault as fault:
        return fault
    return None


def mean_force(sensor, count=10):
    """Return the mean of some new readings, N."""
    forces = {}
    end = time.monotonic() + LIMIT
    while len(forces) < count:
        assert time.monotonic() < end, "no new reading comes"
        reading = sensor.wrench(1e6)
        forces[reading.sequence] = reading.value.force
        time.sleep(0.002)
    return [sum(axis) / count for axis in zip(*forces.values(), strict=True)]


def test_every_fault_is_in_a_table():
    assert {row[0] for row in (*ENDS, *HARMLESS)} | OTHERS == set(AtiStandIn.FAULTS)


def newest(device):
    """Return the number of the newest reading, 0 while a fault keeps it back."""
    try:
        return device.wrench(1e6).sequence
    except DeviceFault:
        return 0


@pytest.mark.parametrize(("fault", "parameters", "kind", "said"), ENDS)
def test_faults_that_stay_until_a_new_run(sensor, fault, parameters, kind, said):
    device, stand_in = sensor
    until(lambda: device.wrench(1e6).sequence > 30)
    stand_in.inject(fault, parameters)
    found = until(lambda: told(device))
    assert type(found) is kind
    with pytest.raises(kind, match=said):
        raise found
    assert device.state is DeviceState.FAULT
    stand_in.clear()
    until(lambda: told(device) is None)
    before = until(lambda: newest(device))
    # on a busy machine the first values after a fault may still be taken for old ones
    until(lambda: newest(device) > before)
    assert device.state is DeviceState.FAULT
    with pytest.raises(DeviceFault, match="until a new run"):
        device.zero()
    device.close()
    device.open()
    assert device.state is DeviceState.READY
    device.zero()


@pytest.mark.parametrize(("fault", "parameters", "counter"), HARMLESS)
def test_faults_of_single_packets_are_counted_and_do_no_harm(sensor, fault, parameters, counter):
    device, stand_in = sensor
    stand_in.inject("load", {"fz": -3.0})
    stand_in.inject(fault, parameters)
    until(lambda: getattr(device.driver.counters(), counter) > 3 and device.wrench(1e6).value.force[2] > 2.9)
    assert mean_force(device)[2] == pytest.approx(3.0, abs=0.01)
    assert device.state is DeviceState.READY


def test_a_sensor_that_is_gone_is_not_opened_again(sensor):
    device, stand_in = sensor
    stand_in.inject("silence")
    until(lambda: told(device))
    device.close()
    with pytest.raises(DeviceLost, match="no measurement"):
        device.open()
    assert device.state is DeviceState.DISCONNECTED


@pytest.mark.parametrize(
    ("fault", "said"), [("freeze", "measures nothing new; switch it off"), ("short", "no records .*36 bytes, not 18")]
)
def test_a_sensor_that_sends_and_does_not_measure_is_told_as_that_on_opening(sensor, fault, said):
    device, stand_in = sensor
    device.close()
    stand_in.inject(fault)
    stand_in._send_one(stand_in._socket.getsockname())  # the cycle at which it stands
    with pytest.raises(DeviceLost, match=f"no measurement from .*: it sends, but {said}"):
        device.open()


def test_a_silence_between_two_readings_is_told_once(sensor):
    device, stand_in = sensor
    sent = stand_in.state()["sent"]
    stand_in.inject("silence", {"seconds": 0.6})
    until(lambda: stand_in.state()["sent"] > sent + 5)
    time.sleep(0.05)
    with pytest.raises(DeviceFault, match=r"silent for .* and sends again"):
        device.wrench(1e6)
    assert device.wrench(1e6).value.torque is not None
    assert device.state is DeviceState.FAULT


def test_zero_is_kept_and_the_load_after_it_is_read(sensor, clock):
    device, stand_in = sensor
    stand_in.inject("load", {"fx": 1.0, "fy": -2.0, "fz": -4.0})
    until(lambda: math.dist(device.wrench(1e6).value.force, (-1.0, 2.0, 4.0)) < 0.05)
    clock.time += 1.0  # earlier readings are too old for the mean
    device.zero()
    assert mean_force(device) == pytest.approx([0.0, 0.0, 0.0], abs=0.005)
    stand_in.inject("load", {"fx": 1.0, "fy": -2.0, "fz": -5.0})
    until(lambda: device.wrench(1e6).value.force[2] > 0.9)
    assert mean_force(device) == pytest.approx([0.0, 0.0, 1.0], abs=0.005)


def test_a_drift_is_a_drift_and_a_slow_stream_is_old(sensor, clock):
    device, stand_in = sensor
    stand_in.inject("drift", {"rate": 20.0})
    until(lambda: device.wrench(1e6).value.force[2] < -1.0)
    clock.time += 5.0
    stand_in.inject("slow", {"rate": 3.0})
    newest = device.wrench(1e6)
    clock._time += 1e6  # nobody waits for a new reading here
    while (said := told(device, age=1.0)) is None:  # one that came just then is taken
        clock._time += 1e6
    assert isinstance(said, StaleReading)
    assert device.driver.wrench().sequence - newest.sequence < 20
    assert device.state is DeviceState.READY


def test_a_reading_is_as_old_as_its_records_were_on_their_way(sensor, clock):
    device, stand_in = sensor
    clock.runs = True
    until(lambda: device.wrench(1e6).sequence > 300)
    stand_in.inject("late", {"delay": 0.3})
    until(lambda: 0.25 < clock.time - device.driver.wrench().host_time < 0.5)
    stand_in.clear()
    until(lambda: clock.time - device.driver.wrench().host_time < 0.1)


def test_a_cycle_number_that_jumps_ahead_makes_no_reading_old(sensor, clock):
    device, stand_in = sensor
    clock.runs = True
    until(lambda: device.wrench(1e6).sequence > 200)
    stand_in._cycle += 1_000_000
    before = device.wrench(1e6).sequence
    until(lambda: device.wrench(1e6).sequence > before + 75)
    assert clock.time - device.driver.wrench().host_time < 0.3, "0.6 s passed since the jump"


def test_times_do_not_fall_where_records_are_found_late(sensor, clock, monkeypatch):
    """After its first second the driver begins to say how late each record was."""
    device, _ = sensor
    clock.runs = True
    late = itertools.cycle((0.0, 0.03))
    monkeypatch.setattr(Delay, "take", lambda self, cycle, arrived: next(late))
    first = device.wrench(1e6).sequence
    until(lambda: device.wrench(1e6).sequence > first + 100)
    times = [measured.time for measured in device.driver._receiver.recent(-1e9)]
    assert all(one < other for one, other in itertools.pairwise(times))


def test_without_noise_values_may_stand_where_the_cell_file_says_so(make_cell):
    cell = make_cell("ati", noisy=False)
    device = cell.devices["force_sensor"]
    before = until(lambda: device.wrench(1e6).sequence)
    cell.stand_in.inject("frozen_force")
    until(lambda: device.wrench(1e6).sequence > before + 100)
    assert device.state is DeviceState.READY


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, (-1.0, -2.0, -3.0)),
        ({"mount": "hand"}, (1.0, 2.0, 3.0)),
        ({"mount": "hand", "rotation": "{x: 180 deg}"}, (1.0, -2.0, -3.0)),
        ({"mount": "table", "rotation": "{z: 90 deg}"}, (2.0, -1.0, -3.0)),
    ],
)
def test_the_mounting_turns_what_is_measured_into_the_world(make_cell, options, expected):
    cell = make_cell("ati", **options)
    cell.stand_in.inject("load", {"fx": 1.0, "fy": 2.0, "fz": 3.0})
    device = cell.devices["force_sensor"]
    until(lambda: math.dist(device.wrench(1e6).value.force, expected) < 0.05)


def test_a_sensor_that_is_not_there(live_cell, clock):
    with pytest.raises(DeviceLost, match=r"force_sensor: no measurement from 127.0.0.1 port 9 .*check its supply"):
        open_cell(load_cell(live_cell("ati", "rdt", "127.0.0.1:9")), now=clock)


def test_closing_stops_the_stream(sensor):
    device, stand_in = sensor
    device.close()
    until(lambda: not stand_in.state()["streaming"])


def test_an_opening_that_a_signal_breaks_off_leaves_nobody_asking(live_cell, clock, monkeypatch):
    """The receiver went on, and took the stream from the next one."""
    ended = []
    monkeypatch.setattr(Receiver, "start", lambda self, within: (_ for _ in ()).throw(KeyboardInterrupt("SIGINT")))
    monkeypatch.setattr(Receiver, "end", lambda self: ended.append(self))
    with pytest.raises(KeyboardInterrupt):
        open_cell(load_cell(live_cell("ati", "rdt", "127.0.0.1:9")), now=clock)
    assert len(ended) == 1
