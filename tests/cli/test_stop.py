"""`stop` as a person gives it: without a run, beside one, and where another program has the robot."""

import json
import os
import re
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from lab import lab_cell

from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.tcp_server import received
from stretch_bt.hardware.emulators.ur import rtde_server

HOST = f"127.9.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
LAB = {"arm": {"watchdog": "1 Hz", "lost_after": "2 s", "heartbeat": "5 s"}, "gripper": {"use": "robotiq_urcap"}}
#: of the stand-in's own time within which the arm stands after `stop` asked for that, s
STANDS = 0.3


@pytest.fixture
def cell(tmp_path):
    """A cell on stand-ins, as a file, and the stand-ins."""
    made = {name: stand_in_class(name)(HOST, StandInWorld()) for name in ("ur", "urcap")}
    for one in made.values():
        one.activated()
        one.start()
    (tmp_path / "lab.yaml").write_text(lab_cell(HOST, LAB))
    yield made
    for one in made.values():
        one.stop()


def told(cli, *options):
    """Run `stop`; return its exit code, and the findings by device."""
    code, out, _ = cli("stop", "lab.yaml", *options, "--json")
    found = {row["check"]: row for row in json.loads(out)}
    assert all(set(row) == {"check", "ok", "detail", "fix"} for row in found.values())
    assert all(row["ok"] or row["fix"] for row in found.values())
    return code, found


def test_where_nothing_moves_it_says_so_and_takes_nothing(cli, cell):
    code, found = told(cli)
    assert (code, found["arm"]["detail"]) == (0, "no program runs on the controller, and the arm stands")
    assert found["gripper"]["detail"].startswith("it holds where it is; opening 5")
    assert list(cell["ur"].controller.events) == []
    assert told(cli, "--device", "arm")[1].keys() == {"arm"}


TREE = """\
format: stretch-tree/1
devices: {arm: Arm, gripper: Gripper}
trees:
  main:
    parallel:
      policy: success_on_all
      children:
        - retract: {clearance: 90 mm, speed: 10 mm/s}
        - set_stretch: {stretch: 70 mm, speed: SPEED}
"""
ALONE = """\
format: stretch-tree/1
devices: {gripper: Gripper}
trees: {main: {set_stretch: {stretch: 70 mm, speed: 3 mm/s}}}
"""


@contextmanager
def running(tree):
    """Run a tree on the cell in a process of its own, and give that process."""
    Path("tree.yaml").write_text(tree)
    command = [
        sys.executable,
        "-m",
        "stretch_bt",
        "run",
        "tree.yaml",
        "--cell",
        "lab.yaml",
        "--out",
        "record",
        "--json",
        "--quiet",
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as run:
        yield run
        run.send_signal(2)


@pytest.mark.parametrize("fingers", [pytest.param("5 mm/s", marks=pytest.mark.slow), "60 mm/s"])
def test_beside_a_run_it_stops_arm_and_fingers_and_the_run_ends(cli, cell, fingers):
    arm, gripper = cell["ur"], cell["urcap"]
    with running(TREE.replace("SPEED", fingers)) as run:
        while arm.state()["speed"] < 0.009 or not gripper.state()["moving"]:
            assert run.poll() is None
            time.sleep(0.01)
        code, found = told(cli)
        said = run.communicate(timeout=20)[0]
        result = json.loads(said)
        assert (run.returncode, result["status"]) == (3, "FAULT")
        assert "the control script ended" in result["reason"]
    assert (code, found["gripper"]["ok"]) == (0, True), found
    assert re.match(
        r"our control script ran \(a run that is open beside this has it\) and the arm moved at \d+ mm/s",
        found["arm"]["detail"],
    )
    after = arm.state()
    [asked] = [float(event.split()[0]) for event in after["events"] if event.endswith("stopped by the dashboard")]
    assert after["moved"] - asked < STANDS
    assert not after["running"]
    assert not gripper.state()["moving"]
    assert gripper.state()["opening"] < 0.120


def test_fingers_that_a_run_leads_on_are_told(cli, cell):
    """Below its slowest speed a gripper is led count by count, by a run that nothing ended."""
    with running(ALONE) as run:
        while not cell["urcap"].state()["moving"]:
            assert run.poll() is None
            time.sleep(0.01)
        code, found = told(cli, "--device", "gripper")
        assert code == 3
        assert "Ctrl-C ends the run" in found["gripper"]["fix"]


LEFT = """
import sys
from rtde_control import RTDEControlInterface as Control
c = Control(sys.argv[1], -1.0, Control.FLAG_UPLOAD_SCRIPT | Control.FLAG_UPPER_RANGE_REGISTERS)
c.speedL([0.0, 0.0, 0.01, 0.0, 0.0, 0.0], 0.5, 0.0)
print("moves", flush=True)
sys.stdin.read()
"""


def test_a_script_whose_client_is_gone_is_stopped(cli, cell):
    command = [sys.executable, "-c", LEFT, HOST]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as client:
        said = client.stdout.readline()
        client.kill()
    assert said == b"moves\n"
    while cell["ur"].state()["speed"] < 0.009:
        time.sleep(0.01)
    code, found = told(cli, "--device", "arm")
    assert (code, found["arm"]["ok"]) == (0, True)
    assert "our control script ran (its client is gone) and the arm moved at 10 mm/s" in found["arm"]["detail"]
    rest = cell["ur"].state()
    assert not rest["running"]
    time.sleep(0.2)
    assert cell["ur"].state()["moved"] == rest["moved"]


@pytest.mark.parametrize("gone", [False, True])
def test_a_script_that_is_paused_does_not_count_as_ended(cli, cell, gone):
    controller = cell["ur"].controller
    command = [sys.executable, "-c", LEFT, HOST]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as client:
        assert client.stdout.readline() == b"moves\n"
        with controller.lock:
            assert controller.pause()
        if gone:
            client.kill()
            while cell["ur"]._rtde._claims:
                time.sleep(0.01)
        code, found = told(cli, "--device", "arm")
        client.kill()
    if gone:
        assert (code, found["arm"]["ok"]) == (3, False)
        assert found["arm"]["detail"].startswith(
            "a program is held, and no client that has it shows that it is ours (PAUSED"
        )
    else:
        assert (code, found["arm"]["ok"]) == (0, True)
        assert "our control script ran (a run that is open beside this has it)" in found["arm"]["detail"]
    assert controller.running == gone


def freed_late(connection):
    """Yield what came over a connection, and let its registers go a while after its end, as a controller may."""
    yield from received(connection)
    time.sleep(0.3)


@pytest.mark.parametrize("ran_before", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_program_of_somebody_else_is_told_and_goes_on(cli, cell, ran_before, monkeypatch):
    """Also where a script of ours ended before: what it wrote in its registers stays."""
    if ran_before:
        code, _, err = cli("move", "lab.yaml", "--up", "1mm", "--yes")
        assert code == 0, err
        assert cell["ur"].controller.registers.out_int[24] in (1, 2)
        while cell["ur"]._rtde._claims:
            time.sleep(0.01)
    monkeypatch.setattr(rtde_server, "received", freed_late)

    def endless():
        while True:
            yield

    with cell["ur"].controller.lock:
        cell["ur"].controller.load(endless(), 0.0)
    while not cell["ur"].controller.running:
        time.sleep(0.01)
    code, found = told(cli, "--device", "arm")
    assert (code, found["arm"]["ok"]) == (3, False)
    assert found["arm"]["detail"].startswith("a program that is not ours runs (PLAYING")
    assert "pendant" in found["arm"]["fix"]
    assert cell["ur"].controller.running


def test_devices_that_do_not_answer_do_not_keep_it_from_the_others(cli, cell):
    cell["ur"].inject("drop")
    code, found = told(cli)
    assert (code, found["arm"]["ok"], found["gripper"]["ok"]) == (3, False, True)
    assert found["arm"]["fix"].startswith("press the emergency stop")
    cell["ur"].clear()
    cell["urcap"].inject("drop")
    code, found = told(cli)
    assert (code, found["arm"]["ok"], found["gripper"]["ok"]) == (3, True, False)


def test_a_frozen_controller_is_told_in_time(cli, cell):
    cell["ur"].inject("freeze")
    begun = time.monotonic()
    code, found = told(cli, "--device", "arm")
    assert (code, "does not answer" in found["arm"]["detail"]) == (3, True)
    assert time.monotonic() - begun < 10.0


def test_what_does_not_move_is_named_and_not_opened(cli, tmp_path):
    (tmp_path / "lab.yaml").write_text(lab_cell("127.0.0.251", {"force_sensor": {}}))
    code, found = told(cli)
    assert (code, found["force_sensor"]["detail"]) == (0, "nothing of it moves")


def test_a_simulated_cell_has_nothing_to_stop(cli):
    code, out, _ = cli("stop", "simulated")
    assert (code, "nothing to connect to" in out) == (0, True)
