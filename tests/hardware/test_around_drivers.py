"""What is around every driver: ownership, limits, ages of readings, and faults that stay."""

import math
from dataclasses import replace

import pytest

from stretch_bt.errors import BeyondLimits, DeviceFault, DeviceLost, InvalidInput, LimitExceeded, NotReady, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.simulation.scene import load_scene

MOVERS = ("arm", "gripper")
READERS = [
    ("simulated", "arm", "pose"),
    ("simulated", "arm", "wrench"),
    ("simulated", "gripper", "opening"),
    ("simulated", "camera", "frame"),
    ("replay", "force_sensor", "wrench"),
]


def start(cell, name, *, far=False, owner="a"):
    """Begin a motion to 50 mm or 75 mm from where the device is at first."""
    way = 0.075 if far else 0.05
    if name == "arm":
        return cell.devices["arm"].move(Pose((way, 0, 0.2)), speed=0.05, owner=owner)
    return cell.devices["gripper"].move(0.055 + way, speed=0.05, owner=owner)


def place(cell, name):
    device = cell.devices[name]
    return device.pose(1.0).value.position[0] if name == "arm" else device.opening(1.0).value - 0.055


@pytest.mark.parametrize(("kind", "name", "reading"), READERS)
def test_readings_are_written_down(make_cell, clock, notes, kind, name, reading):
    read = getattr(make_cell(kind, only=[name]).devices[name], reading)
    for _ in range(3):
        read(1.0)
        clock.time += 0.05
    assert notes.lines.count(("reading", name, reading)) == 3


@pytest.mark.parametrize(("kind", "name", "reading"), READERS)
def test_closed_devices_and_bad_ages_are_refused(make_cell, kind, name, reading):
    device = make_cell(kind, only=[name]).devices[name]
    for age in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidInput, match="max_age"):
            getattr(device, reading)(age)
    device.close()
    with pytest.raises(NotReady, match="closed"):
        getattr(device, reading)(1.0)


@pytest.mark.parametrize(("kind", "age"), [("simulated", 0.03), ("replay", 0.09)])
def test_a_frame_that_is_too_old_is_refused_and_the_camera_stays_ready(make_cell, clock, notes, kind, age):
    camera = make_cell(kind).devices["camera"]
    clock.time += age
    assert camera.frame(age + 0.001).value.raw.size > 0
    with pytest.raises(StaleReading, match=r"is 0\.0\d+ s old"):
        camera.frame(age - 0.01)
    assert camera.state is DeviceState.READY
    assert ("fault", "camera", "StaleReading") in notes.lines


# events between a first motion of `a` and a second look at it: (events, state of the first, whether anything is moving)
OWNERSHIP = [
    ([], "moving", True),
    (["a stops"], "stopped", False),
    (["a stops", "a stops"], "stopped", False),
    (["safe stop"], "stopped", False),
    (["b starts"], "preempted", True),
    (["b starts", "a stops"], "preempted", True),
    (["b starts", "b stops"], "preempted", False),
    (["b starts", "b stops", "a stops"], "preempted", False),
    (["b starts", "safe stop"], "preempted", False),
    (["a stops", "b starts", "a stops"], "stopped", True),
    (["time passes", "b starts", "a stops"], "done", True),
    (["time passes", "a stops"], "stopped", False),
]


@pytest.mark.parametrize("name", MOVERS)
@pytest.mark.parametrize(("events", "expected", "moving"), OWNERSHIP)
def test_only_the_owner_of_the_current_motion_stops_it(make_cell, clock, name, events, expected, moving):
    cell = make_cell(only=[name])
    motions = {"a": start(cell, name)}
    clock.time += 0.2
    for event in events:
        match event.split():
            case ["b", "starts"]:
                motions["b"] = start(cell, name, far=True, owner="b")
            case [owner, "stops"]:
                motions[owner].stop()
            case ["safe", "stop"]:
                assert cell.stop() == []
            case ["time", "passes"]:
                clock.time += 5.0
        clock.time += 0.05
    assert motions["a"].poll() == expected
    clock.time += 0.15  # any braking is over
    here = place(cell, name)
    clock.time += 0.05
    assert (place(cell, name) != here) is moving


def test_commands_and_polls_are_written_down(make_cell, notes):
    cell = make_cell()
    motion = start(cell, "arm", owner="main/approach")
    motion.poll()
    motion.stop()
    assert notes.lines == [
        ("command", "arm", "move", "main/approach"),
        ("motion", "arm", "main/approach", MotionState.MOVING),
        ("command", "arm", "stop", "main/approach"),
    ]


BEYOND = [
    (lambda c: c.devices["arm"].move(Pose((0, 0, -0.01)), speed=0.1, owner="a"), r"height -10 mm .* 0 mm to 500 mm"),
    (lambda c: c.devices["arm"].move(Pose((0, 0, 0.9)), speed=0.1, owner="a"), r"height 900 mm"),
    (lambda c: c.devices["arm"].move(Pose((0.4, 0, 0.1)), speed=0.1, owner="a"), r"x 400 mm .* -300 mm to 300 mm"),
    (lambda c: c.devices["arm"].follow([Pose(), Pose((0, 1, 0))], speed=0.1, owner="a"), r"y 1000 mm"),
    (lambda c: c.devices["arm"].move(Pose(), speed=0.3, owner="a"), r"speed 300 mm/s .* at most 250 mm/s"),
    (lambda c: c.devices["gripper"].move(0.140, speed=0.1, owner="a"), r"stretch 85 mm .* 0 mm to 80 mm"),
    (lambda c: c.devices["gripper"].move(0.050, speed=0.1, owner="a"), r"stretch -5 mm"),
    (lambda c: c.devices["gripper"].move(0.060, speed=0.2, owner="a"), r"speed 200 mm/s .* at most 150 mm/s"),
]


@pytest.mark.parametrize(("command", "said"), BEYOND)
def test_commands_beyond_the_limits_are_never_sent(make_cell, notes, command, said):
    cell = make_cell()
    with pytest.raises(BeyondLimits, match=said):
        command(cell)
    assert [line[0] for line in notes.lines] == ["fault"]
    assert all(d.state is DeviceState.READY for d in cell.devices.values())
    assert start(cell, "arm").poll() is MotionState.MOVING


def test_a_refused_command_leaves_the_motion_before_it(make_cell):
    cell = make_cell()
    motion = start(cell, "arm")
    with pytest.raises(LimitExceeded):
        cell.devices["arm"].move(Pose((0, 0, 0.9)), speed=0.1, owner="b")
    assert motion.poll() is MotionState.MOVING


def test_depth_is_limited_once_contact_is_known(make_cell):
    cell = make_cell()
    arm = cell.devices["arm"]
    arm.move(Pose((0, 0, 0.025)), speed=0.1, owner="a")
    cell.hand.contact_height = 0.06
    with pytest.raises(LimitExceeded, match=r"depth 35 mm .* at most 30 mm"):
        arm.move(Pose((0, 0, 0.025)), speed=0.1, owner="a")


@pytest.mark.parametrize("name", MOVERS)
def test_a_speed_must_be_one(make_cell, name):
    device = make_cell(only=[name]).devices[name]
    for speed in (0.0, -0.1, math.nan, math.inf):
        with pytest.raises(InvalidInput, match="speed"):
            device.move(Pose() if name == "arm" else 0.06, speed=speed, owner="a")


def test_other_bad_commands(make_cell):
    cell = make_cell()
    with pytest.raises(InvalidInput, match="opening"):
        cell.devices["gripper"].move(math.nan, speed=0.1, owner="a")
    with pytest.raises(InvalidInput, match="at least one pose"):
        cell.devices["arm"].follow([], speed=0.1, owner="a")


@pytest.mark.parametrize("kind", ["simulated", "replay"])
def test_a_fault_of_the_device_stays_until_it_is_opened_again(make_cell, monkeypatch, clock, notes, kind):
    """Whatever raises inside a driver: readings fail as they do, commands are refused."""
    sensor = make_cell(kind).devices["force_sensor"]
    with monkeypatch.context() as broken:
        broken.setattr(sensor.driver, "wrench", lambda: (_ for _ in ()).throw(ConnectionResetError("gone")))
        with pytest.raises(DeviceLost, match="force_sensor: the connection broke"):
            sensor.wrench(1.0)
    assert sensor.state is DeviceState.FAULT
    assert ("fault", "force_sensor", "DeviceLost") in notes.lines
    assert sensor.wrench(1.0).value.torque is not None
    sensor.open()
    assert sensor.state is DeviceState.FAULT
    with pytest.raises(NotReady, match=r"in fault until a new run: the connection broke .*; start a new run"):
        sensor.zero()
    sensor.close()
    assert sensor.fault is not None
    sensor.open()
    assert sensor.fault is None
    assert sensor.state is DeviceState.READY
    sensor.zero()


@pytest.mark.parametrize("name", MOVERS)
def test_a_mover_in_fault_refuses_to_move_but_stops(make_cell, monkeypatch, clock, name):
    cell = make_cell(only=[name])
    device = cell.devices[name]
    motion = start(cell, name)
    clock.time += 0.2
    device.latch(DeviceFault(name, "protective stop"))
    with pytest.raises(DeviceFault, match="protective stop"):
        motion.poll()
    with pytest.raises(NotReady, match="protective stop"):
        start(cell, name)
    device.stop()
    clock.time += 1.0
    rest = place(cell, name)
    clock.time += 1.0
    assert place(cell, name) == rest
    device.close()
    device.open()
    assert place(cell, name) == rest
    assert start(cell, name).poll() is MotionState.MOVING


def test_too_much_force_stops_the_arm(clock, advance):
    spec = load_cell("simulated")
    spec = replace(spec, limits=spec.limits.model_copy(update={"force": 1.0}))
    cell = open_cell(spec, now=clock, scene=load_scene("calibration_cylinder"))
    arm = cell.devices["arm"]
    motion = arm.move(Pose((0, 0, 0.04)), speed=0.05, owner="a")
    with pytest.raises(LimitExceeded, match=r"force .* at most 1 N"):
        advance(motion)
    assert arm.state is DeviceState.FAULT
    clock.time += 1.0
    assert 0.043 < arm.pose(1.0).value.height < 0.05


def test_too_much_force_on_an_arm_that_stands_is_a_fault_as_soon_as_it_is_read(make_cell, monkeypatch, advance):
    cell = make_cell()
    arm, wrench = cell.devices["arm"], cell.devices["arm"].driver.wrench
    assert advance(start(cell, "arm")) is MotionState.DONE
    monkeypatch.setattr(arm.driver, "wrench", lambda: replace(wrench(), value=Wrench((0.0, 0.0, 21.0))))
    with pytest.raises(LimitExceeded, match="force 21 N is past the limit of the cell, at most 20 N"):
        arm.wrench(1.0)
    assert arm.state is DeviceState.FAULT
    assert arm.wrench(1.0).value.magnitude == 21.0
    with pytest.raises(NotReady):
        start(cell, "arm", far=True)
    monkeypatch.undo()
    arm.close()
    arm.open()
    assert advance(start(cell, "arm", far=True)) is MotionState.DONE
