"""Every fault that the stand-in of a UR controller can show, while the hand is on its way; and processes that are killed."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from waiting import LIMIT, eventually

from stretch_bt.errors import DeviceFault, DeviceLost, LimitExceeded, NotReady
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.force_noise import CB3, NoisyForce
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn, Ur5StandIn
from stretch_bt.hardware.examine import doctor
from stretch_bt.hardware.interfaces import DeviceState, MotionState
from stretch_bt.hardware.ur.arm_process import ArmProcess

#: of the cell, so that faults come soon; a machine that is too busy for them makes faults of its own, after which a test goes on
DEADLINES = {"watchdog": "2.5 Hz", "lost_after": "400 ms", "heartbeat": "500 ms", "unwatched": "1 s"}

# (fault, parameters, what the fault of the arm says)
LOSSES = [
    ("drop", {}, "connection"),
    ("close", {}, "connection"),
    ("reset", {}, "connection"),
    ("freeze", {}, "nothing new came"),
    ("slow", {"rate": 1.0}, "nothing new came"),
    ("late", {"delay": 1.0}, "nothing new came"),
    ("repeat", {}, "nothing new came|does not follow"),
    ("truncate", {}, "connection|ended"),
    ("garbage", {"bytes": 300}, "connection"),
    ("corrupt", {}, "connection"),
]
OWN = [
    ("protective_stop", {"locked": 0.2}, "protective stop: look for its cause"),
    ("safeguard_stop", {}, "safeguard stop: close the safeguard"),
    ("violation", {}, "violation of the safety configuration"),
    ("program_stop", {}, "the control script ended"),
    ("home", {}, "the control script ended"),
    ("no_solution", {}, "the control script ended|takes no commands"),
    ("deaf", {}, "does not follow"),
    ("stall", {}, "does not follow"),
    ("slider", {"fraction": 0.05}, "speed slider"),
    ("frozen_force", {}, "sent the same force for"),
    ("load", {"fz": 24.0}, "N is past the limit of the cell, at most 20 N"),
    ("load", {"fz": 50.0}, "N in one sample is past 40 N"),
    ("wall", {"height": 0.18, "stiffness": 20000.0}, "N is past the limit of the cell|N in one sample is past"),
]
#: faults that another one here stands for, by what the arm sees of them and says
ALIKE = {
    "close",
    "reset",
    "slow",
    "late",
    "truncate",
    "garbage",
    "home",
    "no_solution",
    "stall",
    "wall",
    "power_off",
}
POWER = [("emergency_stop", "emergency stop: release the button"), ("power_off", "the control script ended")]
#: of a controller before it is connected, and one that does no harm
OTHERS = {"registers", "local", "loss"}


def rows(table):
    """Return a table for parametrize; rows that others stand for are marked slow."""
    return [pytest.param(*row, marks=[pytest.mark.slow] if row[0] in ALIKE else []) for row in table]


@pytest.fixture(scope="module")
def shared(tmp_path_factory, own_hosts, write_cell):
    """A cell on a stand-in, which the tests leave able to move again."""
    behind = Ur5StandIn(next(own_hosts), StandInWorld())
    places = behind.start()
    path = write_cell(tmp_path_factory.mktemp("ur"), "ur", "rtde", places["rtde"], **DEADLINES)
    cell = open_cell(load_cell(path), now=time.monotonic)
    cell.stand_in = behind
    yield cell
    cell.close()
    behind.stop()


@pytest.fixture
def moving(shared):
    """Return the cell, its arm, and a motion that is under way downwards."""

    def begin():
        arm = shared.devices["arm"]
        motion = eventually(lambda: under_way(arm, shared.stand_in))
        return shared, arm, motion

    yield begin
    shared.hand.contact_height = None
    shared.stand_in.clear()
    arm = shared.devices["arm"]
    eventually(lambda: arm.state is DeviceState.READY or anew(arm))


def anew(arm):
    """Close the arm, and open it as a new run does; return whether it takes motions."""
    arm.close()
    arm.open()
    return arm.state is DeviceState.READY


def released(controller):
    """Release the brakes as at the pendant, which does nothing while the button is down, and return whether they are."""
    controller.release_brakes()
    return controller.released


def fault_of(motion):
    """Poll a motion until it raises a fault, and return that."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        try:
            assert motion.poll() is MotionState.MOVING
        except DeviceFault as fault:
            return fault
        time.sleep(0.01)
    raise AssertionError("no fault comes")


def under_way(arm, stand_in):
    """Return a motion downwards that has its speed."""
    if arm.state is not DeviceState.READY:
        anew(arm)
    up = arm.move(Pose((0, 0, 0.2)), speed=0.25, owner="up")
    while up.poll() is MotionState.MOVING:
        time.sleep(0.01)
    motion = arm.move(Pose((0, 0, 0.1)), speed=0.05, owner="a")
    while stand_in.state()["speed"] < 0.045:
        assert motion.poll() is MotionState.MOVING
        time.sleep(0.01)
    return motion


def stands(stand_in):
    """Wait until the arm stands, and return whether it goes on standing for a while of the controller's time."""
    eventually(lambda: not stand_in.state()["moving"])
    before = stand_in.state()
    eventually(lambda: stand_in.state()["time"] > before["time"] + 0.1)
    return stand_in.state()["moved"] == before["moved"]


def goes_again(arm):
    """Open the arm as a new run does, and see that it moves."""
    eventually(lambda: anew(arm) and rises(arm))


def rises(arm):
    """Return whether the arm goes up a little."""
    rest = arm.pose(10.0).value.height
    motion = arm.move(Pose((0, 0, rest + 0.005)), speed=0.1, owner="b")
    while (state := motion.poll()) is MotionState.MOVING:
        time.sleep(0.01)
    return state is MotionState.DONE and abs(arm.pose(10.0).value.height - rest - 0.005) < 2e-4


def test_every_fault_is_in_a_table():
    named = {fault for fault, *_ in [*LOSSES, *OWN, *POWER]}
    assert named | OTHERS == set(Ur5StandIn.FAULTS)


@pytest.mark.parametrize(("fault", "parameters", "said"), rows(LOSSES), ids=lambda p: p if isinstance(p, str) else "")
def test_a_loss_ends_the_motion_and_nothing_moves_until_a_new_run(moving, fault, parameters, said):
    cell, arm, motion = moving()
    cell.stand_in.inject(fault, parameters)
    lost = fault_of(motion)
    assert any(word in str(lost) for word in said.split("|")), lost
    assert arm.state is DeviceState.FAULT
    cell.stop()
    assert stands(cell.stand_in)
    cell.stand_in.clear()
    with pytest.raises(NotReady, match="in fault until a new run"):
        arm.move(Pose((0, 0, 0.1)), speed=0.05, owner="a")
    assert stands(cell.stand_in)
    goes_again(arm)


@pytest.mark.parametrize(("fault", "parameters", "said"), rows(OWN), ids=lambda p: p if isinstance(p, str) else "")
def test_a_fault_of_the_controller_ends_the_motion(moving, fault, parameters, said):
    cell, arm, motion = moving()
    cell.stand_in.inject(fault, parameters)
    told = fault_of(motion)
    assert not isinstance(told, DeviceLost)
    assert any(word in str(told) for word in said.split("|")), told
    assert arm.state is DeviceState.FAULT
    cell.stop()
    assert stands(cell.stand_in)
    assert cell.stand_in.state()["height"] > 0.1
    if fault == "wall":
        cell.stand_in.inject("wall", {"height": 0.0})
    cell.stand_in.clear()
    if fault == "protective_stop":
        with pytest.raises(DeviceFault, match=r"protective stop: .* unlock it at the pendant"):
            anew(arm)
        eventually(cell.stand_in.controller.unlock)
    goes_again(arm)


@pytest.mark.parametrize(("fault", "said"), rows(POWER))
def test_without_power_the_fault_stays_until_a_person_was_at_the_pendant(moving, fault, said):
    cell, arm, motion = moving()
    cell.stand_in.inject(fault)
    assert said in str(fault_of(motion))
    cell.stop()
    assert stands(cell.stand_in)
    cell.stand_in.clear()
    with pytest.raises(DeviceFault, match="switch power and brakes on at the pendant"):
        anew(arm)
    assert arm.state is DeviceState.DISCONNECTED
    eventually(lambda: released(cell.stand_in.controller))
    goes_again(arm)


def test_a_part_of_the_packages_is_enough(moving):
    cell, arm, motion = moving()
    cell.stand_in.inject("loss", {"part": 0.5})
    eventually(lambda: motion.poll() is MotionState.DONE)
    assert arm.pose(1.0).value.height == pytest.approx(0.1, abs=2e-4)


@pytest.mark.parametrize(
    ("prepare", "said"),
    [
        (lambda s: s.inject("registers"), "already in use"),
        pytest.param(lambda s: s.inject("power_off"), "switch power and brakes on", marks=pytest.mark.slow),
        (lambda s: s.inject("protective_stop", {"locked": 0.0}), "protective stop: .* unlock it at the pendant"),
        (lambda s: s.controller.load(iter(lambda: None, 0), 0.0), "runs a program"),
    ],
)
def test_a_controller_that_cannot_be_moved_is_not_opened(
    make_cell, stand_in, tmp_path, live_cell, clock, prepare, said
):
    behind, _ = stand_in("ur")
    prepare(behind)
    eventually(lambda: behind.state()["time"] > 0.05)
    with pytest.raises(DeviceFault, match=said):
        open_cell(load_cell(live_cell("ur", "rtde", behind.host)), now=clock)
    state = behind.state()
    assert not state["moving"]
    assert (state["safety"] == "PROTECTIVE_STOP") is ("protective" in said)


def test_a_program_that_somebody_begins_as_the_arm_opens_goes_on(stand_in, live_cell, clock, monkeypatch):
    behind, _ = stand_in("ur")
    behind.controller.load(iter(lambda: None, 0), 0.0)
    eventually(lambda: behind.controller.running)
    latest = ArmProcess.latest

    def before(process):
        sample = latest(process)
        return replace(sample, value=replace(sample.value, program=False))

    monkeypatch.setattr(ArmProcess, "latest", before)
    with pytest.raises(DeviceFault, match="runs a program"):
        open_cell(load_cell(live_cell("ur", "rtde", behind.host)), now=clock)
    assert behind.controller.running, behind.state()["events"]


def test_a_newer_controller_has_to_be_in_remote_control(stand_in, live_cell, clock):
    behind, _ = stand_in("ur5e")
    path = live_cell("ur", "rtde", behind.host, model="ur5e")
    behind.inject("local")
    with pytest.raises(DeviceFault, match="enable remote control"):
        open_cell(load_cell(path), now=clock)
    behind.clear()
    cell = open_cell(load_cell(path), now=clock)
    try:
        motion = cell.devices["arm"].move(Pose((0, 0, 0.19)), speed=0.1, owner="a")
        eventually(lambda: motion.poll() is MotionState.DONE)
        # done is within the arm's tolerance; on a busy machine it settles after that
        eventually(lambda: abs(behind.state()["height"] - 0.19) < 1e-4)
    finally:
        cell.close()


def test_the_newest_controllers_are_given_the_lower_registers(own_hosts, live_cell, clock):
    class Newest(Ur5eStandIn):
        PROFILE = Ur5eStandIn.PROFILE._replace(version=(5, 23, 0, 1))

    behind = Newest(next(own_hosts), StandInWorld())
    behind.start()
    try:
        cell = open_cell(load_cell(live_cell("ur", "rtde", behind.host, model="ur5e")), now=clock)
        assert cell.devices["arm"].state is DeviceState.READY
        cell.close()
    finally:
        behind.stop()


def test_nobody_there_and_the_wrong_robot_are_told(stand_in, live_cell, clock):
    with pytest.raises(DeviceLost, match=r"cannot be reached at 127\.0\.0\.250"):
        open_cell(load_cell(live_cell("ur", "rtde", "127.0.0.250")), now=clock)
    behind, _ = stand_in("ur")
    with pytest.raises(DeviceFault, match="`model` or `hand` of the cell file do not fit this robot"):
        open_cell(load_cell(live_cell("ur", "rtde", behind.host, model="ur5e", loaded="true")), now=clock)


def test_what_cannot_be_reached_is_refused_and_leaves_the_arm_ready(make_cell):
    arm = make_cell("ur").devices["arm"]
    with pytest.raises(LimitExceeded, match=r"pose .* mm .*(reached|stretched|deg/s)"):
        arm.move(Pose((0.49, 0, 0.2)), speed=0.05, owner="a")
    arm.driver.options = arm.driver.options.model_copy(update={"joint_speed": 0.1})
    with pytest.raises(LimitExceeded, match=r"turn at \d+ deg/s, allowed are 6; go slower"):
        arm.move(Pose((0.1, 0, 0.2)), speed=0.2, owner="a")
    assert arm.state is DeviceState.READY


def test_contact_ends_a_motion_as_blocked(make_cell):
    cell = make_cell("ur", contact_force="5 N")
    cell.stand_in.inject("wall", {"height": 0.19, "stiffness": 2000.0})
    arm = cell.devices["arm"]
    motion = arm.move(Pose((0, 0, 0.15)), speed=0.02, owner="a")
    assert eventually(lambda: motion.poll() is not MotionState.MOVING and motion.poll()) is MotionState.BLOCKED
    assert 0.15 < arm.pose(1.0).value.height < 0.1875
    assert arm.state is DeviceState.READY


def test_the_depth_past_first_contact_is_watched_in_every_cycle(moving):
    """Contact becomes known while the hand is already on its way below what that allows."""
    cell, arm, motion = moving()
    cell.hand.contact_height = 0.2
    assert re.search(r"depth [\d.]+ mm is past the limit of the cell, at most 25 mm", str(fault_of(motion)))
    assert arm.pose(1.0).value.height > 0.165


def test_a_stop_that_would_take_longer_than_the_watchdog_waits_is_made_sooner(stand_in, live_cell):
    behind, places = stand_in("ur")
    soft = {**DEADLINES, "stop_acceleration": "0.05 m/s²"}
    cell = open_cell(load_cell(live_cell("ur", "rtde", places["rtde"], **soft)), now=time.monotonic)
    try:
        arm = cell.devices["arm"]
        motion = eventually(lambda: under_way(arm, behind))
        motion.stop()
        assert stands(behind)
        assert not any("watchdog" in event for event in behind.state()["events"])
        assert arm.pose(10.0).value.height > 0.11
        assert arm.state is DeviceState.READY
    finally:
        cell.close()


@pytest.mark.parametrize("limit", ["force", pytest.param("depth", marks=pytest.mark.slow)])
def test_an_arm_that_stands_past_a_limit_is_in_fault_until_a_new_run(moving, limit):
    cell, arm, _ = moving()
    arm.stop()
    assert stands(cell.stand_in)
    eventually(lambda: arm.state is DeviceState.READY or anew(arm))  # what a busy machine made of it
    if limit == "force":
        cell.stand_in.inject("load", {"fz": 30.0})
    else:
        cell.hand.contact_height = arm.pose(10.0).value.height + 0.05
    assert f"{limit} " in str(read_until_fault(arm))
    cell.stand_in.clear()
    cell.hand.contact_height = None
    assert arm.state is DeviceState.FAULT
    with pytest.raises(NotReady):
        arm.move(Pose((0, 0, 0.2)), speed=0.1, owner="b")
    assert stands(cell.stand_in)
    goes_again(arm)


def test_an_arm_that_is_opened_past_a_limit_is_not_ready(stand_in, live_cell):
    behind, places = stand_in("ur")
    behind.inject("load", {"fz": 30.0})
    spec = load_cell(live_cell("ur", "rtde", places["rtde"], **DEADLINES, tare="false"))
    said = r"force [\d.]+ N is past the limit of the cell, at most 20 N; see why, move the hand back at the pendant"
    with pytest.raises(DeviceFault, match=said):
        open_cell(spec, now=time.monotonic)
    [ready] = [found for found in doctor(spec) if found.check == "arm: ready"]
    assert not ready.ok
    assert re.search(said, ready.detail)


def read_until_fault(arm):
    """Read where the arm is until that raises a fault, and return it."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        try:
            arm.pose(10.0)
        except DeviceFault as fault:
            return fault
        time.sleep(0.01)
    raise AssertionError("no fault comes")


def test_a_motion_that_nobody_looks_at_is_stopped(moving):
    cell, arm, motion = moving()
    eventually(lambda: not cell.stand_in.state()["moving"])
    assert "no tick looked at the motion" in str(fault_of(motion))
    assert stands(cell.stand_in)
    assert cell.stand_in.state()["height"] > 0.11
    goes_again(arm)


@pytest.mark.parametrize(
    ("model", "load", "most", "loaded"),
    [
        ("ur5", 20.0, r"1[12]\.\d N", "false"),
        pytest.param("ur5", 20.0, r"1[12]\.\d N", "true", marks=pytest.mark.slow),
        pytest.param("ur5e", 20.0, r"4\.\d N", "false", marks=pytest.mark.slow),
        ("ur5e", 20.0, r"4\.\d N", "true"),
    ],
)
def test_a_load_at_opening_is_refused_unless_the_cell_file_allows_it(
    stand_in, live_cell, clock, model, load, most, loaded
):
    """The sensor of a UR5e is zeroed at each start of a program: a hand that presses would be held to the limit less what it feels."""
    behind, _ = stand_in({"ur5": "ur", "ur5e": "ur5e"}[model])
    behind.inject("load", {"fz": load})
    spec = load_cell(live_cell("ur", "rtde", behind.host, model=model, loaded=loaded))
    if loaded == "false":
        said = rf"it feels \d\d\.\d N before a run, where bias and noise of a {model} explain {most}, .*`loaded: true`"
        with pytest.raises(NotReady, match=said):
            open_cell(spec, now=clock)
        eventually(lambda: not behind.state()["running"])
        return
    cell = open_cell(spec, now=clock)
    try:
        arm = cell.devices["arm"]
        assert felt(arm) == pytest.approx((0.0, 0.0, 0.0), abs=1.5)
        behind.inject("load", {"fz": load - 10.0})
        assert felt(arm) == pytest.approx((0.0, 0.0, -10.0), abs=1.5)
    finally:
        cell.close()


def felt(arm):
    """Return the mean of the force that a standing arm feels over a second, N, after its filter forgot what was before."""
    read = []
    eventually(lambda: read.append(arm.wrench(1e9)) or read[-1].device_time > read[0].device_time + 1.2)
    late = {r.device_time: r.value.force for r in read if r.device_time > read[0].device_time + 0.2}
    return tuple(np.mean(list(late.values()), axis=0))


def test_a_bias_at_opening_is_taken_as_zero_unless_the_cell_file_says_otherwise(stand_in, live_cell, clock):
    behind, _ = stand_in("ur")
    behind.inject("load", {"fx": 1.0, "fz": -2.0})
    bias = NoisyForce(CB3, 0).error[:3] + [1.0, 0.0, -2.0]
    for tare, force in (("true", (0.0, 0.0, 0.0)), ("false", tuple(bias))):
        cell = open_cell(load_cell(live_cell("ur", "rtde", behind.host, tare=tare)), now=clock)
        try:
            arm = cell.devices["arm"]
            assert felt(arm) == pytest.approx(force, abs=2.0)
        finally:
            cell.close()


# --- processes that are killed


def test_killing_the_process_of_the_driver_is_a_fault_and_the_watchdog_stops_the_arm(moving):
    cell, arm, motion = moving()
    before = cell.stand_in.state()["time"]
    os.kill(arm.driver.process, signal.SIGKILL)
    assert "ended by SIGKILL" in str(fault_of(motion))
    assert cell.stand_in.state()["time"] - before < 0.5
    assert stands(cell.stand_in)
    state = cell.stand_in.state()
    assert any("watchdog" in event for event in state["events"])
    assert state["moved"] - before < 1.0
    goes_again(arm)


def test_a_process_that_hangs_is_a_loss(moving):
    cell, arm, motion = moving()
    os.kill(arm.driver.process, signal.SIGSTOP)
    said = str(fault_of(motion))
    assert "no sign of life" in said or "without a force reading" in said
    assert stands(cell.stand_in)
    goes_again(arm)


RUN = """
import sys, time
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
arm = open_cell(load_cell(sys.argv[1]), now=time.monotonic).devices["arm"]
arm.move(Pose((0, 0, 0.1)), speed=0.02, owner="a")
print(arm.driver.process, flush=True)
time.sleep(60)
"""


@pytest.mark.parametrize(
    "both", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["the run alone", "its driver too"]
)
def test_killing_the_run_stops_the_arm_and_leaves_no_process(stand_in, live_cell, both):
    behind, _ = stand_in("ur")
    path = live_cell("ur", "rtde", behind.host, **DEADLINES)
    with subprocess.Popen([sys.executable, "-c", RUN, str(path)], stdout=subprocess.PIPE) as run:
        driver = json.loads(run.stdout.readline())
        eventually(lambda: behind.state()["speed"] > 0.015)
        before = behind.state()["time"]
        for pid in [run.pid, driver][: 1 + both]:
            os.kill(pid, signal.SIGKILL)
    eventually(lambda: not Path(f"/proc/{driver}").exists() or "zombie" in Path(f"/proc/{driver}/status").read_text())
    assert stands(behind)
    state = behind.state()
    assert not state["running"]
    assert state["height"] > 0.12
    assert state["moved"] - before < 1.0
    assert any("watchdog" in event for event in state["events"]) is both


def test_a_run_that_hangs_has_its_arm_stopped(stand_in, live_cell):
    behind, _ = stand_in("ur")
    path = live_cell("ur", "rtde", behind.host, **DEADLINES)
    with subprocess.Popen([sys.executable, "-c", RUN, str(path)], stdout=subprocess.PIPE) as run:
        run.stdout.readline()
        eventually(lambda: behind.state()["speed"] > 0.015)
        os.kill(run.pid, signal.SIGSTOP)
        assert stands(behind)
        assert behind.state()["height"] > 0.12
        run.kill()
