"""`move` as a person gives it: on the simulated cell, and on the stand-in of a controller."""

import json
import os
import re
import threading
import time
from pathlib import Path

import pytest
from lab import lab_cell

from stretch_bt.hardware.emulators.registry import stand_in_class
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld

HOST = f"127.8.{os.getpid() // 250 % 250}.{1 + os.getpid() % 250}"
LAB = {"arm": {"watchdog": "1 Hz", "lost_after": "2 s", "heartbeat": "5 s"}}
LIMITS = "limits: {height: {min: 20 mm, max: 300 mm}, speed: 100 mm/s, contact: {below: 150 mm, speed: 20 mm/s}}\n"
FIVE = ("--speed", "5mm/s")


@pytest.fixture
def behind(tmp_path):
    """A stand-in, and beside it a cell file that names it."""
    made = stand_in_class("ur")(HOST, StandInWorld())
    made.start()
    (tmp_path / "lab.yaml").write_text(lab_cell(HOST, LAB) + LIMITS)
    yield made
    made.stop()


def height(stand_in):
    return stand_in.state()["height"]


def found_in(out):
    """Return the one finding that is printed."""
    [finding] = json.loads(out)
    assert set(finding) == {"check", "ok", "detail", "fix"}
    assert finding["check"] == "arm"
    return finding


def test_it_goes_up_and_comes_back_down(cli, behind):
    code, out, err = cli("move", "lab.yaml", "--up", "10 mm", "--speed", "50mm/s", "--yes", "--json")
    assert (code, found_in(out)["ok"]) == (0, True), err
    assert re.match(
        r"the hand stands at a height of 210\.\d mm, 9\.\d+ mm higher|.* 10\.\d+ mm higher", found_in(out)["detail"]
    )
    assert "goes up by 10 mm at 50 mm/s, from a height of 200.0 mm to 210.0 mm, in about 0.2 s" in err
    assert height(behind) == pytest.approx(0.210, abs=2e-4)
    code, out, _ = cli("move", "lab.yaml", "--down", "20mm", "--speed", "50mm/s", "--yes")
    assert (code, out.startswith("ok  arm: the hand stands at a height of 190.0 mm")) == (0, True)
    assert height(behind) == pytest.approx(0.190, abs=2e-4)
    assert not behind.controller.running


# (options, exit code, part of the message)
REFUSED = [
    ((), 2, "name one of --up and --down"),
    (("--up", "10mm", "--down", "10mm"), 2, "name one of --up and --down"),
    (("--up", "0mm"), 2, "more than 0 mm"),
    (("--up", "-5mm"), 2, "more than 0 mm"),
    (("--up", "10"), 2, "10 has no unit"),
    (("--up", "10mm", "--speed", "5mm"), 2, "5mm is Length, not Speed"),
    (("--up", "10mm", "--device", "leg"), 2, "'leg' is no arm of lab.yaml; name one with --device: arm"),
    (("--down", "60mm"), 2, "--down ends at a height of 140.0 mm, and below 150 mm the hand may meet something"),
    (("--up", "110mm"), 1, "height 310 mm is past the limits of the cell, 20 mm to 300 mm"),
    (("--up", "10mm", "--speed", "101mm/s"), 1, "speed 101 mm/s is past the limit of the cell, at most 100 mm/s"),
]


def test_what_it_refuses_moves_nothing(cli, behind):
    for asked, expected, said in REFUSED:
        code, out, err = cli("move", "lab.yaml", *asked, "--yes", "--json")
        assert code == expected, asked
        assert said in out + err
        json.loads(out)
    assert behind.state()["moved"] == 0.0
    assert not behind.controller.running


@pytest.mark.parametrize(
    ("joint_speed", "asked", "said", "fix"),
    [
        ("60 deg/s", ("--up", "110mm"), "height 310 mm is past", "go less far"),
        ("60 deg/s", ("--up", "10mm", "--speed", "101mm/s"), "speed 101 mm/s is past", "go more slowly"),
        ("1 deg/s", ("--up", "10mm", "--speed", "99mm/s"), "go slower", "go more slowly"),
    ],
)
def test_what_to_do_goes_by_the_limit_that_is_concerned(cli, behind, joint_speed, asked, said, fix):
    Path("lab.yaml").write_text(lab_cell(HOST, {"arm": {**LAB["arm"], "joint_speed": joint_speed}}) + LIMITS)
    found = found_in(cli("move", "lab.yaml", *asked, "--yes", "--json")[1])
    assert (said in found["detail"], found["fix"]) == (True, fix), found


@pytest.mark.parametrize(
    ("typed", "goes"), [("y\n", True), ("", False), pytest.param("n\n", False, marks=pytest.mark.slow)]
)
def test_it_asks_and_does_not_move_without_a_yes(cli, behind, monkeypatch, tmp_path, typed, goes):
    (tmp_path / "typed").write_text(typed)
    with (tmp_path / "typed").open() as answers:
        monkeypatch.setattr("sys.stdin", answers)
        code, out, err = cli("move", "lab.yaml", "--up", "5mm", "--speed", "50mm/s")
    assert "hand on the emergency stop?" in err
    assert (code, out.lstrip().startswith("ok")) == ((0, True) if goes else (1, False))
    assert (behind.state()["moved"] > 0) is goes


def test_ctrl_c_stops_it_where_it_is(cli, behind):
    def interrupt():
        while height(behind) < 0.205:
            time.sleep(0.005)
        os.kill(os.getpid(), 2)

    thread = threading.Thread(target=interrupt, daemon=True)
    thread.start()
    code, out, _ = cli("move", "lab.yaml", "--up", "80mm", "--speed", "20mm/s", "--yes", "--json")
    thread.join()
    found = found_in(out)
    assert (code, found["ok"]) == (130, False)
    assert found["detail"].startswith("stopped by Ctrl-C; the hand stands at a height of 2")
    rest = behind.state()
    assert rest["height"] < 0.28
    time.sleep(0.3)
    assert behind.state()["moved"] == rest["moved"]
    assert not behind.controller.running


def test_what_holds_the_hand_ends_it_and_a_fault_is_told(cli, behind):
    def pull():
        while height(behind) < 0.203:
            time.sleep(0.005)
        behind.inject("load", {"fz": -15.0})

    thread = threading.Thread(target=pull, daemon=True)
    thread.start()
    code, out, _ = cli("move", "lab.yaml", "--up", "80mm", "--speed", "10mm/s", "--yes", "--json")
    thread.join()
    assert (code, found_in(out)["ok"]) == (1, False)
    assert re.search(
        r"the force changed by 1\d\.\d N on the way, so that something holds the hand", found_in(out)["detail"]
    )
    assert height(behind) < 0.28
    behind.clear()
    behind.inject("protective_stop")
    code, out, _ = cli("move", "lab.yaml", "--up", "5mm", "--yes", "--json")
    assert (code, "protective stop" in found_in(out)["detail"]) == (3, True)


def test_a_controller_that_is_not_there_is_told(cli, tmp_path):
    (tmp_path / "lab.yaml").write_text(lab_cell("127.0.0.251", LAB))
    code, out, _ = cli("move", "lab.yaml", "--up", "5mm", "--yes", "--json")
    assert (code, "cannot be reached" in found_in(out)["detail"]) == (3, True)


def test_the_simulated_cell_moves_without_a_question(cli, tmp_path):
    code, out, err = cli("move", "simulated", "--up", "10mm", *FIVE, "--json")
    assert (code, found_in(out)["detail"]) == (
        0,
        "the hand stands at a height of 130.0 mm, 10.00 mm higher than before, after 2.05 s",
    )
    assert "Is nothing in the way" not in err
    code, _, err = cli("move", "simulated", "--down", "10mm")
    assert (code, "does not say where the hand may meet something" in err) == (2, True)
    Path("cell.yaml").write_text(
        "format: stretch-cell/1\ndevices: {arm: {type: Arm, use: simulated}}\nlimits: {contact: {below: 100 mm, speed: 4 mm/s}}\n"
    )
    code, out, _ = cli("move", "cell.yaml", "--down", "10mm", *FIVE)
    assert (code, "10.00 mm lower" in out) == (0, True)
