"""What every implementation of a device keeps to."""

import inspect
import math
import os
import subprocess
import sys
from dataclasses import replace

import pytest
from lab import lab_cell
from real_cell import CELL, MOVE, SPEED, gone, rows, target

from stretch_bt.errors import BeyondLimits, DeviceFault, DeviceLost, InvalidInput, LimitExceeded, NotReady, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.driver import Bench
from stretch_bt.hardware.emulators.serve import serving
from stretch_bt.hardware.emulators.stage import Stage
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.implementations import SHIPPED, driver_class
from stretch_bt.hardware.interfaces import INTERFACES, DeviceState, MotionState
from stretch_bt.simulation.scene import load_scene

#: kinds of cell whose device is reached over a wire, and what the cell file calls the device
LIVE = {
    "robotiq-rtu": "robotiq",
    "robotiq-tcp": "robotiq",
    "robotiq-serial": "robotiq",
    "urcap": "robotiq_urcap",
    "ati": "ati",
    "ur": "ur",
    "realsense": "realsense",
}
GRIPPERS = [kind for kind, use in LIVE.items() if use not in ("ati", "ur", "realsense")]
MOVERS = [("simulated", "arm"), ("simulated", "gripper"), *((kind, "gripper") for kind in GRIPPERS), ("ur", "arm")]
#: how far a position may be from what was asked for, m, where it is counted in steps, or settled to
STEP = {**dict.fromkeys(GRIPPERS, 0.0007), "ur": 0.0001, "hardware": 0.006}
#: how far a device goes on by its own clock while it is told to stop, m: at 50 mm/s on a machine that is busy
LATE = {"ur": 0.02, "hardware": 0.03}
READERS = [
    ("simulated", "arm", "pose"),
    ("simulated", "arm", "wrench"),
    ("simulated", "gripper", "opening"),
    ("simulated", "camera", "frame"),
    ("simulated", "force_sensor", "wrench"),
    ("replay", "arm", "pose"),
    ("replay", "arm", "wrench"),
    ("replay", "camera", "frame"),
    ("replay", "force_sensor", "wrench"),
    *((kind, "gripper", "opening") for kind in GRIPPERS),
    ("ati", "force_sensor", "wrench"),
    ("ur", "arm", "pose"),
    ("ur", "arm", "wrench"),
    ("realsense", "camera", "frame"),
]
#: with those that have nothing to read; a person at a terminal is in a test of its own
DEVICES = sorted({*((kind, name) for kind, name, _ in READERS), ("simulated", "operator")})
#: wires on which a gripper is what it is on the first one: that it moves there is in the default run
ALIKE = ("robotiq-tcp", "robotiq-serial")
#: the same of a cell of one's own
REAL_READERS, REAL_MOVERS, REAL_DEVICES = rows()


def sparse(table):
    """Return a table for parametrize, rows of wires that another one stands for marked slow."""
    return [pytest.param(*row, marks=[pytest.mark.slow] if row[0] in ALIKE else []) for row in table]


def start(cell, name, *, far=False, owner="a"):
    """Begin a motion to 50 mm or 75 mm from where the device is at first."""
    way = 0.075 if far else 0.05
    if hasattr(cell, "homes"):
        return cell.devices[name].move(target(cell, name, way), speed=SPEED, owner=owner)
    if name == "arm":
        return cell.devices["arm"].move(Pose((way, 0, 0.2)), speed=0.05, owner=owner)
    return cell.devices["gripper"].move(0.055 + way, speed=0.05, owner=owner)


def place(cell, name):
    if hasattr(cell, "homes"):
        return gone(cell, name)
    device = cell.devices[name]
    return device.pose(1.0).value.position[0] if name == "arm" else device.opening(1.0).value - 0.055


def test_the_readers_cover_every_implementation():
    specs = {(kind, name): load_cell("simulated").devices[name].type for kind, name in DEVICES}
    assert {(specs[key], LIVE.get(key[0], key[0])) for key in specs} == set(SHIPPED) - {("Operator", "console")}


@pytest.mark.parametrize("key", SHIPPED, ids="-".join)
def test_constructing_touches_nothing(key, tmp_path, clock, live_cell):
    """A driver with a recording that is not there and without a scene can be constructed, closed and stopped."""
    cls = driver_class(*key)
    interface, use = key
    limits = load_cell("simulated").limits
    if use in LIVE.values():
        options = next(iter(load_cell(live_cell(use, "none", "192.0.2.1:9")).devices.values())).options
    else:
        fields = {"file": "none.npz", "depth": "z", "unit": "1 mm", "intrinsics": "K"} if use == "replay" else {}
        wanted = {k: v for k, v in fields.items() if k in cls.Options.model_fields}
        options = cls.Options.model_validate({"type": interface, "use": use, **wanted})
    driver = cls("d", options, Bench(clock, 0, tmp_path, Hand(), limits))
    assert not driver.ended
    driver.close()
    assert clock.time == 0.0


@pytest.mark.parametrize(("kind", "name"), sparse(DEVICES) + REAL_DEVICES)
def test_states_from_open_to_closed(make_cell, kind, name):
    cell = make_cell(kind, only=[name])
    device = cell.devices[name]
    assert isinstance(device, INTERFACES[cell.spec.devices[name].type])
    assert device.state is DeviceState.READY
    device.open()
    for _ in range(2):
        device.close()
        assert device.state is DeviceState.DISCONNECTED
    device.stop()
    device.open()
    assert device.state is DeviceState.READY


@pytest.mark.parametrize(("kind", "name", "reading"), sparse(READERS) + REAL_READERS)
def test_readings_have_times_and_numbers_and_are_written_down(make_cell, clock, notes, kind, name, reading):
    cell = make_cell(kind, only=[name])
    read = getattr(cell.devices[name], reading)
    first = read(1.0)
    again = read(1.0)
    assert (first.sequence, first.host_time) == (again.sequence, again.host_time) or (
        kind in (*LIVE, "hardware") and again.sequence > first.sequence  # its wire does not stand still with the clock
    )
    clock.time += 0.15
    later = read(1.0)
    assert later.sequence > first.sequence
    assert first.host_time < later.host_time <= clock.time
    assert later.device_time > first.device_time
    assert notes.lines.count(("reading", name, reading)) == 3


@pytest.mark.parametrize(("kind", "name", "reading"), sparse(READERS) + REAL_READERS)
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


@pytest.mark.parametrize(("kind", "name"), MOVERS + REAL_MOVERS)
def test_motion_takes_time_and_arrives(make_cell, clock, advance, kind, name):
    cell = make_cell(kind, only=[name])
    motion = start(cell, name)
    assert place(cell, name) == pytest.approx(0.0, abs=STEP.get(kind, 0.0))
    assert motion.poll() is MotionState.MOVING
    assert advance(motion) is MotionState.DONE
    assert clock.time >= 0.9 * 0.05 / 0.05  # of a clock that one with its own may be ahead of
    assert place(cell, name) == pytest.approx(0.05, abs=STEP.get(kind, 1e-12))
    assert motion.poll() is MotionState.DONE


PATIENCE = 10  # looks at whether a motion is under way


@pytest.mark.parametrize(("kind", "name"), sparse(MOVERS) + REAL_MOVERS)
def test_stop_midway(make_cell, clock, advance, kind, name):
    cell = make_cell(kind, only=[name])
    rest = place(cell, name)
    motion = start(cell, name)
    for _ in range(PATIENCE):
        clock.time += 0.3
        if place(cell, name) > rest + 1e-6:  # a real client begins when its machine lets it
            break
    before = place(cell, name)
    motion.stop()
    assert motion.poll() is MotionState.STOPPED
    clock.time += 1.0
    assert rest < before <= place(cell, name) <= before + 0.05**2 / (2 * 0.5) + LATE.get(kind, STEP.get(kind, 1e-9))
    rest = place(cell, name)
    clock.time += 1.0
    assert place(cell, name) == rest
    assert advance(start(cell, name)) is MotionState.DONE


# what happens between a first motion of `a` and a second look at it: (events, state of the first, is anything moving)
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
#: rows in which the arm itself does what no other test here has it do
OF_AN_ARM = {3, 5}


def owned():
    """Yield every mover with every row; those of one that takes its real time, and that are of what is common to all, are slow."""
    for mover in sparse(MOVERS) + REAL_MOVERS:
        values, marks = (mover.values, list(mover.marks)) if hasattr(mover, "marks") else (mover, [])
        for k, row in enumerate(OWNERSHIP):
            slow = [pytest.mark.slow] if values[0] == "ur" and k not in OF_AN_ARM else []
            yield pytest.param(*values, *row, marks=marks + slow)


@pytest.mark.parametrize(("kind", "name", "events", "expected", "moving"), list(owned()))
def test_only_the_owner_of_the_current_motion_stops_it(make_cell, clock, kind, name, events, expected, moving):
    cell = make_cell(kind, only=[name])
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


@pytest.mark.parametrize(("kind", "name"), sparse(MOVERS) + REAL_MOVERS)
def test_a_speed_must_be_one(make_cell, kind, name):
    device = make_cell(kind, only=[name]).devices[name]
    for speed in (0.0, -0.1, math.nan, math.inf):
        with pytest.raises(InvalidInput, match="speed"):
            device.move(Pose() if name == "arm" else 0.06, speed=speed, owner="a")


def test_other_bad_commands(make_cell):
    cell = make_cell()
    with pytest.raises(InvalidInput, match="opening"):
        cell.devices["gripper"].move(math.nan, speed=0.1, owner="a")
    with pytest.raises(InvalidInput, match="at least one pose"):
        cell.devices["arm"].follow([], speed=0.1, owner="a")


@pytest.mark.parametrize("kind", ["simulated", "replay", "ati"])
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


@pytest.mark.parametrize(("kind", "name"), sparse(MOVERS) + REAL_MOVERS)
def test_a_mover_in_fault_refuses_to_move_but_stops(make_cell, monkeypatch, clock, kind, name):
    cell = make_cell(kind, only=[name])
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


def test_drivers_document_themselves():
    for key in SHIPPED:
        cls = driver_class(*key)
        assert inspect.getdoc(cls)
        assert cls.Options.model_fields["type"].annotation.__args__ == (key[0],)
        assert cls.Options.model_fields["use"].annotation.__args__ == (key[1],)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({CELL: "nowhere.yaml"}, "nowhere"),
        ({CELL: "lab_ur5", MOVE: "arm,gripper"}, "nothing that moves named arm,gripper; write names of"),
        ({CELL: "lab_ur5", MOVE: "arm camera"}, "nothing that moves named camera"),
    ],
)
def test_a_cell_of_ones_own_that_is_asked_for_wrongly_is_refused_at_once(monkeypatch, told, said):
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    for name in (CELL, MOVE):
        monkeypatch.delenv(name, raising=False)
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(pytest.UsageError, match=said):
        rows()


@pytest.mark.parametrize(
    "told",
    [{MOVE: "arm"}, {CELL: "lab_ur5"}, {CELL: "lab_ur5", MOVE: "arm", "PYTEST_XDIST_WORKER": "gw0"}],
    ids=["no cell", "nothing to move", "several processes"],
)
def test_nothing_moves_that_was_not_asked_for(monkeypatch, told):
    for name in (CELL, MOVE, "PYTEST_XDIST_WORKER"):
        monkeypatch.delenv(name, raising=False)
    for name, value in told.items():
        monkeypatch.setenv(name, value)
    [row] = rows()[1]
    assert row.marks[0].name == "skip"


@pytest.mark.slow
def test_a_cell_file_of_ones_own_is_held_to_all_of_this(own_hosts, librealsense, tmp_path):
    """Stand-ins take the place of the hardware."""
    host = next(own_hosts)
    names = ("arm", "gripper", "force_sensor", "camera")
    (tmp_path / "own.yaml").write_text(lab_cell(host, {name: {} for name in names}))
    told = {CELL: str(tmp_path / "own.yaml"), MOVE: "arm gripper"}
    with serving(["ur", "robotiq", "ati", "realsense"], Stage(), host=host, activated=True):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-rs", __file__, "-k", "hardware-"],
            env={**{k: v for k, v in os.environ.items() if not k.startswith("PYTEST_XDIST")}, **told},
            capture_output=True,
            text=True,
            check=False,
        )
    print(done.stdout)  # noqa: T201
    assert done.returncode == 0, done.stdout
    assert "skipped" not in done.stdout
