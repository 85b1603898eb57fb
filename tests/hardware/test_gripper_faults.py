"""Every fault that the stand-ins of a gripper can show, while the fingers are on their way."""

import sys
import time

import pytest
from waiting import LIMIT, eventually

from stretch_bt.errors import DeviceFault, DeviceLost, LimitExceeded, MissingExtra, NotReady
from stretch_bt.hardware.emulators import robotiq, urcap
from stretch_bt.hardware.emulators.gripper_model import GRIPPER_FAULTS
from stretch_bt.hardware.emulators.line import LINE_FAULTS
from stretch_bt.hardware.emulators.robotiq import RobotiqStandIn
from stretch_bt.hardware.emulators.urcap import UrcapStandIn
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.hardware.robotiq.registers import FAULTS, Command

ALL = ("robotiq-rtu", "robotiq-tcp", "robotiq-serial", "urcap")
NETWORK = ("robotiq-rtu", "robotiq-tcp", "urcap")
TIMEOUT = "300 ms"
#: wires on which these losses are as on the first one
ALIKE = ("robotiq-tcp", "robotiq-serial")
OF_THEIR_OWN = ("drop", "refuse")
#: that the second driver takes as the first one does
LIKE_RTU = ("reset", "slow", "late", "truncate", "corrupt")

# (kinds, fault, parameters, what the fault says)
LOSSES = [
    (ALL, "drop", {}, "connection|no answer"),
    (NETWORK, "reset", {}, "clos|broke"),
    (ALL, "freeze", {}, "no answer"),
    (ALL, "slow", {"delay": 1.2}, "no answer"),
    (NETWORK, "late", {}, "no answer"),
    (ALL, "corrupt", {}, "answer"),
    (ALL, "truncate", {}, "answer"),
    (ALL, "garbage", {"bytes": 400}, "answer|without"),
    (("robotiq-rtu", "robotiq-serial", "robotiq-tcp"), "crc", {}, "answer"),
    (("robotiq-rtu", "robotiq-serial"), "unit", {}, "answer"),
    (("robotiq-tcp",), "refuse", {}, "Modbus exception 4"),
    (("urcap",), "nothing", {}, "emergency stop"),
]
OWN = [
    *(("code", {"code": code}, f"fault {code:02X}: {FAULTS[code].means}") for code in FAULTS),
    ("code", {"code": 0x01}, "fault 01: a fault that the manual does not list"),
    ("deactivate", {}, "lost its activation"),
    ("stall", {}, "the fingers do not move"),
]


def repeats(kind, fault):
    """Return whether a loss on a wire is the same as on another wire."""
    return fault not in OF_THEIR_OWN if kind in ALIKE else kind == "urcap" and fault in LIKE_RTU


@pytest.fixture
def moving(make_cell, clock):
    """Return a cell on a stand-in, its gripper, and a motion that is under way to 125 mm."""

    def begin(kind):
        cell = make_cell(kind, timeout=TIMEOUT)
        gripper = cell.devices["gripper"]
        motion = gripper.move(0.125, speed=0.05, owner="a")
        clock.time += 0.3
        assert motion.poll() is MotionState.MOVING
        return cell, gripper, motion

    return begin


def fault_of(motion, clock):
    """Poll a motion until it raises a fault, and return that."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        try:
            assert motion.poll() is MotionState.MOVING
        except DeviceFault as fault:
            return fault
        clock.time += 0.05
    raise AssertionError("no fault comes")


def test_every_fault_is_in_a_table():
    lines = {fault for _, fault, _, _ in LOSSES}
    own = {fault for fault, _, _ in OWN} | {"object", "deaf", "wild"}
    assert lines | own == set(RobotiqStandIn.FAULTS) | set(UrcapStandIn.FAULTS)
    assert set(LINE_FAULTS) <= lines
    assert own == set(GRIPPER_FAULTS)


@pytest.mark.parametrize(
    ("kind", "fault", "parameters", "said"),
    [
        pytest.param(k, f, p, s, marks=[pytest.mark.slow] if repeats(k, f) else [])
        for kinds, f, p, s in LOSSES
        for k in kinds
    ],
)
def test_a_loss_ends_the_motion_and_nothing_moves_until_a_new_run(moving, clock, kind, fault, parameters, said):
    cell, gripper, motion = moving(kind)
    cell.stand_in.inject(fault, parameters)
    lost = fault_of(motion, clock)
    assert isinstance(lost, DeviceLost)
    assert any(word in str(lost) for word in said.split("|")), lost
    assert gripper.state is DeviceState.FAULT
    for error in cell.stop():
        assert "may go on" in str(error) or "connection" in str(error)
    cell.stand_in.clear()
    clock.time += 2.0
    rest = cell.stand_in.state()
    assert not rest["moving"]
    with pytest.raises(NotReady, match=r"in fault until a new run: the connection broke .*; start a new run"):
        gripper.move(0.08, speed=0.05, owner="a")
    with pytest.raises(DeviceLost, match="start a new run"):
        gripper.opening(100.0)
    clock.time += 1.0
    assert cell.stand_in.state()["writes"] == rest["writes"]
    gripper.close()
    gripper.open()
    assert gripper.state is DeviceState.READY
    near = pytest.approx(rest["opening"], abs=0.0007)
    eventually(lambda: gripper.opening(100.0).value == near)  # on a serial line an answer may be one question late
    gripper.move(0.08, speed=0.05, owner="a")
    eventually(lambda: cell.stand_in.state()["moving"])


@pytest.mark.parametrize(
    ("kind", "fault", "parameters", "said"),
    [
        pytest.param(kind, *row, marks=[pytest.mark.slow] if kind == "urcap" and 0 < k < len(FAULTS) else [])
        for kind in ("robotiq-rtu", "urcap")
        for k, row in enumerate(OWN)
    ],
    ids=lambda p: str(p)[:24],
)
def test_a_fault_of_the_gripper_ends_the_motion(moving, clock, advance, kind, fault, parameters, said):
    cell, gripper, motion = moving(kind)
    cell.stand_in.inject(fault, parameters)
    told = fault_of(motion, clock)
    assert not isinstance(told, DeviceLost)
    assert said in str(told)
    assert gripper.state is DeviceState.FAULT
    assert cell.stop() == []
    clock.time += 1.0
    assert not cell.stand_in.state()["moving"]
    cell.stand_in.clear()
    gripper.close()
    gripper.open()
    assert gripper.state is DeviceState.READY
    if fault == "deactivate" or (fault == "code" and FAULTS.get(parameters["code"], (0, 0, True))[2]):
        with pytest.raises(DeviceFault, match="stretch-bt activate"):
            gripper.move(0.08, speed=0.05, owner="a")
        gripper.close()
        gripper.open()
        assert advance(gripper.activate(owner="a")) is MotionState.DONE
    assert advance(gripper.move(0.08, speed=0.15, owner="a")) is MotionState.DONE


def test_fingers_that_are_led_and_stand_are_told_of_as_soon_as_others(make_cell, clock):
    cell = make_cell("robotiq-rtu", timeout=TIMEOUT)
    motion = cell.devices["gripper"].move(0.115, speed=0.005, owner="a")
    clock.time += 0.3
    assert motion.poll() is MotionState.MOVING
    cell.stand_in.inject("stall")
    before = clock.time
    assert "the fingers do not move" in str(fault_of(motion, clock))
    assert clock.time - before < 5.0, "of the twelve that the way takes"


@pytest.mark.parametrize(
    ("fault", "said"), [("code", "fault 0C: an internal fault"), ("deactivate", "lost its activation")]
)
@pytest.mark.parametrize("kind", ["robotiq-rtu", "urcap"])
def test_what_happens_while_the_fingers_stand_is_told_once_by_a_reading(make_cell, clock, kind, fault, said):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    cell.stand_in.inject(fault)
    cell.stand_in.clear()
    clock.time += 0.1
    with pytest.raises(DeviceFault, match=said):
        gripper.opening(1.0)
    assert gripper.opening(1.0).value == pytest.approx(0.055, abs=0.0007)
    assert gripper.state is DeviceState.FAULT
    gripper.close()
    gripper.open()
    clock.time += 0.1
    assert gripper.opening(1.0).value == pytest.approx(0.055, abs=0.0007)
    assert gripper.state is DeviceState.READY


@pytest.mark.parametrize("kind", [pytest.param(k, marks=[pytest.mark.slow] * (k in ALIKE)) for k in NETWORK])
def test_fingers_whose_wire_broke_once_are_held_on_a_new_connection(moving, clock, kind):
    cell, _, motion = moving(kind)
    cell.stand_in.inject("reset")
    assert isinstance(fault_of(motion, clock), DeviceLost)
    assert cell.stop() == []
    clock.time += 1.0
    assert not cell.stand_in.state()["moving"]
    assert cell.stand_in.state()["opening"] < 0.1, "of the 125 mm to which they were sent"


def test_a_gripper_that_is_too_hot_stays_so_in_a_new_run(moving, clock, advance):
    cell, gripper, motion = moving("robotiq-rtu")
    cell.stand_in.inject("code", {"code": 0x08})
    assert "too hot" in str(fault_of(motion, clock))
    gripper.close()
    gripper.open()
    with pytest.raises(DeviceFault, match="let it cool down, then start a new run"):
        gripper.move(0.08, speed=0.05, owner="a")
    cell.stand_in.clear()
    gripper.close()
    gripper.open()
    assert advance(gripper.move(0.08, speed=0.15, owner="a")) is MotionState.DONE


@pytest.mark.parametrize("kind", ["robotiq-rtu", "urcap"])
def test_commands_that_are_confirmed_and_not_obeyed(make_cell, clock, kind):
    cell = make_cell(kind)
    cell.stand_in.inject("deaf")
    motion = cell.devices["gripper"].move(0.1, speed=0.05, owner="a")
    assert "does not follow its command" in str(fault_of(motion, clock))


@pytest.mark.parametrize("kind", ["robotiq-tcp", "urcap"])
def test_an_object_blocks_the_fingers_either_way(make_cell, advance, kind):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    cell.stand_in.inject("object", {"opening": 0.08})
    assert advance(gripper.move(0.12, speed=0.1, owner="a")) is MotionState.BLOCKED
    assert gripper.opening(1.0).value == pytest.approx(0.08, abs=0.0007)
    assert not cell.stand_in.model.command.go, "they would go on once nothing is in their way"
    cell.stand_in.clear("object")
    assert advance(gripper.move(0.12, speed=0.1, owner="a")) is MotionState.DONE
    cell.stand_in.inject("object", {"opening": 0.09})
    assert advance(gripper.move(0.06, speed=0.1, owner="a")) is MotionState.BLOCKED
    assert gripper.opening(1.0).value == pytest.approx(0.09, abs=0.0007)
    assert gripper.state is DeviceState.READY


@pytest.mark.parametrize("fault", ["corrupt", "truncate", "garbage", "freeze", "slow"])
@pytest.mark.parametrize("kind", [pytest.param(k, marks=[pytest.mark.slow] * (k in ALIKE)) for k in ALL])
def test_one_bad_answer_is_asked_for_again(make_cell, advance, kind, fault):
    """And an answer that came too late is never taken for one to a later question."""
    cell = make_cell(kind, timeout=TIMEOUT)
    gripper = cell.devices["gripper"]
    motion = gripper.move(0.1, speed=0.1, owner="a")
    parameters = {"delay": 0.2} if fault == "slow" else {}
    cell.stand_in.inject(fault, {"times": 1, **parameters})
    assert advance(motion) is MotionState.DONE
    assert gripper.opening(1.0).value == pytest.approx(0.1, abs=0.0007)
    assert cell.stand_in.faults.active() == []


def test_a_late_answer_on_a_serial_line_does_not_end_a_motion_early(make_cell, advance, clock):
    cell = make_cell("robotiq-serial", timeout=TIMEOUT)
    gripper = cell.devices["gripper"]
    assert advance(gripper.move(0.1, speed=0.1, owner="a")) is MotionState.DONE
    cell.stand_in.inject("late", {"times": 2})
    motion = gripper.move(0.06, speed=0.1, owner="a")
    assert motion.poll() is MotionState.MOVING
    assert advance(motion) is MotionState.DONE
    assert cell.stand_in.state()["opening"] == pytest.approx(0.06, abs=0.0007)


def test_slow_answers_within_the_time_of_an_exchange_are_no_fault(make_cell, advance):
    cell = make_cell("robotiq-rtu")
    cell.stand_in.inject("slow", {"delay": 0.01})
    assert advance(cell.devices["gripper"].move(0.06, speed=0.1, owner="a")) is MotionState.DONE


def test_a_command_waits_for_all_its_exchanges_where_each_is_slow_and_in_time(make_cell, advance):
    """A status by the URCap takes seven: one is under way, and the motion asks for another."""
    cell = make_cell("urcap", timeout="100 ms")
    cell.stand_in.inject("slow", {"delay": 0.08, "times": 20})
    time.sleep(0.1)  # a poll is under way
    assert advance(cell.devices["gripper"].move(0.06, speed=0.1, owner="a")) is MotionState.DONE


def test_a_gripper_that_takes_longer_than_its_time_is_told_with_what_to_raise(make_cell):
    gripper = make_cell("robotiq-rtu").devices["gripper"]
    gripper.driver._attendant._deadline = 0.0
    with pytest.raises(DeviceLost, match=r"check its line, and raise `timeout` if it is slow\); start a new run"):
        gripper.driver.status()


@pytest.mark.parametrize("kind", ["robotiq-rtu", "urcap"])
def test_nothing_moves_on_open_and_an_inactive_gripper_says_how_to_activate_it(make_cell, clock, advance, kind):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    cell.stand_in.model.lose_activation()
    gripper.close()
    writes = cell.stand_in.state()["writes"]
    gripper.open()
    gripper.stop()
    clock.time += 1.0
    assert cell.stand_in.state()["writes"] == writes
    assert gripper.opening(1.0).value == pytest.approx(0.055, abs=0.0007)
    with pytest.raises(NotReady, match=r"not activated; take the membrane off.*stretch-bt activate"):
        gripper.move(0.08, speed=0.05, owner="a")
    assert not cell.stand_in.state()["moving"]
    motion = gripper.activate(owner="b")
    for _ in range(2):  # the reset, and the activation once that is shown
        clock.time += 0.1
        assert motion.poll() is MotionState.MOVING
    with pytest.raises(NotReady, match="being activated"):
        gripper.move(0.08, speed=0.05, owner="a")


@pytest.mark.parametrize("kind", ["robotiq-rtu", "urcap"])
def test_an_activation_can_be_broken_off(make_cell, clock, kind):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    gripper.activate(owner="a")
    clock.time += 0.2
    assert cell.stand_in.state()["moving"]
    gripper.stop()
    clock.time += 0.2
    assert not cell.stand_in.state()["moving"]
    assert not gripper.driver.status().ready


def test_an_activation_whose_begin_is_not_shown_yet_can_be_broken_off(make_cell, clock, monkeypatch):
    cell = make_cell("urcap")
    monkeypatch.setattr(urcap, "QUESTIONS", 10**9)  # what it shows changes with the clock alone
    gripper = cell.devices["gripper"]
    gripper.activate(owner="a")
    clock.time += 0.1
    assert cell.stand_in.state()["moving"]
    gripper.stop()
    assert not cell.stand_in.model.command.activate
    clock.time += 1.0
    assert not cell.stand_in.state()["moving"]


def test_an_activation_ends_an_automatic_release(make_cell, clock, advance):
    cell = make_cell("urcap")
    gripper = cell.devices["gripper"]
    cell.stand_in._reply("SET ATR 1")
    clock.time += 20.0
    with pytest.raises(DeviceFault, match=r"fault 0F: .*stretch-bt activate"):
        gripper.move(0.08, speed=0.05, owner="a")
    gripper.close()
    gripper.open()
    assert advance(gripper.activate(owner="a")) is MotionState.DONE
    assert advance(gripper.move(0.08, speed=0.15, owner="a")) is MotionState.DONE


@pytest.mark.parametrize("questions", range(1, 11))
def test_a_fault_that_the_command_clears_does_not_end_the_motion(make_cell, clock, advance, monkeypatch, questions):
    """However long the URCap shows it."""
    monkeypatch.setattr(urcap, "QUESTIONS", questions)
    cell = make_cell("urcap")
    cell.stand_in.model._fault = 0x09
    clock.time += 0.1
    gripper = cell.devices["gripper"]
    motion = gripper.move(0.08, speed=0.15, owner="a")
    for _ in range(3):
        gripper.driver.status()
        assert motion.poll() is MotionState.MOVING
    assert advance(motion) is MotionState.DONE


def test_slower_than_the_gripper_can_it_is_led(make_cell, clock, advance):
    """The 2F-140 goes at 30 mm/s or more; 10 mm/s come from steps."""
    cell = make_cell("robotiq-rtu")
    gripper = cell.devices["gripper"]
    motion = gripper.move(0.085, speed=0.01, owner="a")
    for k in range(1, 25):
        clock.time = 0.1 * k
        assert motion.poll() is MotionState.MOVING
        assert gripper.opening(1.0).value == pytest.approx(0.055 + 0.001 * k, abs=0.0025)
    assert advance(motion) is MotionState.DONE
    assert clock.time == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("kind", ["robotiq-rtu", "urcap"])
def test_fingers_that_leave_the_limits_are_stopped(make_cell, clock, kind):
    """Somebody else sends them on while they move."""
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    motion = gripper.move(0.13, speed=0.15, owner="a")
    clock.time += 0.4
    assert motion.poll() is MotionState.MOVING
    cell.stand_in.model.write(Command(activate=True, go=True, position=3, speed=255))
    clock.time += 0.5
    with pytest.raises(LimitExceeded, match=r"stretch 8\d(\.\d)? mm is past .*, 0 mm to 80 mm; see what .* `stretch`"):
        motion.poll()
    assert gripper.state is DeviceState.FAULT
    assert not cell.stand_in.state()["moving"]
    gripper.close()
    gripper.open()
    back = gripper.move(0.12, speed=0.15, owner="a")
    clock.time += 0.02
    assert back.poll() is MotionState.MOVING


@pytest.mark.parametrize("count", [2, 6])
def test_a_status_of_another_length_is_an_answer(make_cell, monkeypatch, count):
    monkeypatch.setattr(robotiq, "_part", lambda registers, at, asked: (registers * 2)[:count])
    with pytest.raises(
        DeviceLost, match=rf"it answers \(its status is {count} registers.*check `read_function` and `unit`"
    ):
        make_cell("robotiq-rtu")


def test_a_client_that_is_not_installed_is_named(make_cell, live_cell, clock, monkeypatch):
    monkeypatch.setitem(sys.modules, "pymodbus", None)
    with pytest.raises(MissingExtra, match="needs pymodbus; install it with: pip install"):
        make_cell("robotiq-rtu")


def test_an_opening_that_was_not_calibrated_is_refused(make_cell):
    cell = make_cell(
        "robotiq-rtu",
        calibration=("{points: [{count: 3, opening: 110 mm}, {count: 200, opening: 10 mm}], source: a test}"),
    )
    with pytest.raises(DeviceFault, match=r"opening 130 mm was not calibrated, but 10 mm to 110 mm; .*`calibration`"):
        cell.devices["gripper"].move(0.13, speed=0.1, owner="a")
    assert cell.devices["gripper"].state is DeviceState.READY


def test_a_gripper_that_is_not_there(live_cell, clock):
    from stretch_bt.hardware.cell import open_cell
    from stretch_bt.hardware.cell_file import load_cell

    for use, wire, place in (
        ("robotiq", "rtu", "127.0.0.1:9"),
        ("robotiq", "serial", "no/such/line"),
        ("robotiq_urcap", "urcap", "127.0.0.1:9"),
    ):
        with pytest.raises(DeviceLost, match="gripper: it does not answer"):
            open_cell(load_cell(live_cell(use, wire, place)), now=clock)
