"""What the script of the client makes of commands that no arm can follow, cycle by cycle, without a client."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.script import ControlScript, parse_script
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn
from stretch_bt.hardware.transforms import six

MOVE_J, MOVE_L, SPEED_J, SPEED_L, PATH, STOP_L = 1, 3, 9, 10, 45, 15
LINE = "def rtde_control():\n# float register offset\n0\n# int register offset\n0\nmovel(p[0,0,0.3,0,3,0],a=0,v=1,r=0)"
ONE = [0.1] * 6
#: a line to the side, and a turn of the hand about it
TURNED = [-0.4, 0.2, 0.2, 0.0, math.pi, 0.0]
#: limit of a joint, rad/s, and some rounding
FASTEST = math.radians(180) * 1.002


@pytest.fixture
def commanded():
    """Return the controller after a command with its doubles, and some cycles."""

    def run(command, doubles, cycles=100, path=(), asynchronous=0):
        controller = Ur5eStandIn("127.0.0.1", StandInWorld()).controller
        controller.load(ControlScript(controller, 0, list(path)).run(), 0.0)
        for _ in range(30):
            controller.cycle()
        controller.begun = controller.arm.q.copy()
        controller.take({f"input_double_register_{k}": float(value) for k, value in enumerate(doubles)})
        controller.take({"input_int_register_0": command, "input_int_register_1": asynchronous})
        for _ in range(cycles):
            controller.cycle()
            assert np.abs(controller.arm.qd).max() < FASTEST
        return controller

    return run


@pytest.mark.parametrize("none", [0.0, -1.0])
@pytest.mark.parametrize(
    ("command", "doubles", "which"),
    [(MOVE_J, ONE, 0), (MOVE_J, ONE, 1), (MOVE_L, ONE, 0), (MOVE_L, ONE, 1), (SPEED_J, ONE, 0), (SPEED_L, ONE, 0)],
)
def test_a_move_without_speed_or_acceleration_ends_the_program(commanded, command, doubles, which, none):
    pace = [0.5, 0.5]
    pace[which] = none
    controller = commanded(command, [*doubles, *pace])
    assert not controller.running
    assert (controller.arm.q == controller.begun).all()
    assert "must be more than 0" in str(controller.events)


@pytest.mark.parametrize(
    ("command", "doubles", "too_fast"),
    [
        (SPEED_L, [0, 0, 3.0, 0, 0, 0, 10.0], True),
        (SPEED_L, [0, 0, 0, 0, 0, 4.0, 10.0], True),
        (MOVE_L, [*TURNED, 50.0, 50.0], True),
        (SPEED_L, [0, 0, 0.1, 0, 0, 0, 1.0], False),
        (MOVE_L, [*TURNED, 0.5, 0.5], False),
    ],
)
def test_a_joint_that_would_pass_its_limit_makes_a_protective_stop(commanded, command, doubles, too_fast):
    controller = commanded(command, doubles, cycles=300)
    assert controller.safety.name == ("PROTECTIVE_STOP" if too_fast else "NORMAL")
    assert controller.running is not too_fast


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_register_that_is_no_number_ends_the_program_and_does_not_repeat_the_command_before(commanded, value):
    controller = commanded(SPEED_L, [0, 0, 0.1, 0, 0, 0, 1.0])
    assert controller.running
    controller.take({f"input_double_register_{k}": value for k in range(6)})
    for _ in range(100):
        controller.cycle()
    assert not controller.running
    assert controller.arm.steady
    assert f"input_double_register_0 is {value}" in str(controller.events)


def test_a_path_without_acceleration_ends_the_program(commanded):
    _, path = parse_script(LINE)
    controller = commanded(PATH, ONE, path=path)
    assert not controller.running
    assert "must be more than 0" in str(controller.events)


def a_path(*legs):
    """Return a path as the client writes it."""
    text = "def rtde_control():\n# float register offset\n0\n# int register offset\n0\n"
    return parse_script(text + "".join(f"\tsignal_async_progress({i})\n\t{leg}\n" for i, leg in enumerate(legs)))[1]


def to(kind, place, pace="a=1.2,v=0.25,r=0"):
    """Return one leg; six joint angles are a list, a pose a tuple."""
    numbers = ",".join(f"{value:.12g}" for value in place)
    return f"{kind}({'p' if isinstance(place, tuple) else ''}[{numbers}],{pace})"


@pytest.fixture
def at():
    """Where the arm stands as it begins: joint angles, and the pose of its tool."""
    arm = Ur5eStandIn("127.0.0.1", StandInWorld()).controller.arm
    pose = six(arm.pose())
    return SimpleNamespace(
        q=arm.q.tolist(),
        turned=[arm.q[0] + 0.1, *arm.q[1:]],
        pose=tuple(pose),
        down=(*pose[:2], pose[2] - 0.02, *pose[3:]),
    )


PLAYED = {
    "no leg": lambda at: ([], at.q),
    "where it is": lambda at: ([to("movel", at.pose)] * 3, at.q),
    "down and back": lambda at: ([to("movel", at.down), to("movel", at.pose)], at.q),
    "at another speed back": lambda at: ([to("movel", at.down), to("movel", at.pose, "a=0.5,v=0.02,r=0")], at.q),
    "joints": lambda at: ([to("movej", at.turned)], at.turned),
    "joints last": lambda at: ([to("movel", at.down), to("movej", at.turned)], at.turned),
    "joints first": lambda at: ([to("movej", at.turned), to("movel", at.pose)], at.q),
    "joints to a pose": lambda at: ([to("movej", at.down), to("movej", at.pose)], at.q),
    "a line to joints": lambda at: ([to("movel", at.turned)], at.turned),
    "a process line": lambda at: ([to("movep", at.down, "a=1.2,v=0.25,r=0.02"), to("movep", at.q)], at.q),
}


@pytest.mark.parametrize("path", PLAYED)
@pytest.mark.parametrize("asynchronous", [0, 1])
def test_a_path_ends_where_its_last_leg_does(commanded, at, path, asynchronous):
    legs, there = PLAYED[path](at)
    controller = commanded(PATH, ONE, cycles=1500, path=a_path(*legs), asynchronous=asynchronous)
    assert controller.running
    assert controller.arm.steady
    assert controller.arm.q == pytest.approx(there, abs=1e-6)
    assert controller.registers.out_int[2] & 1 << 15 == 0, "no operation goes on"


def test_each_leg_of_a_path_has_its_own_speed(commanded, at):
    slow = to("movel", at.down, "a=1.2,v=0.02,r=0")
    controller = commanded(PATH, ONE, cycles=150, path=a_path(to("movel", at.pose), slow))
    assert 0 < at.pose[2] - six(controller.arm.pose())[2] < 0.01


@pytest.mark.parametrize(
    ("second", "why"),
    [
        ("movel(p[nan,0,0.3,0,3,0],a=1.2,v=0.25,r=0)", "leg 2 of the path: nan is no place"),
        ("movel(p[0,0,1e999,0,3,0],a=1.2,v=0.25,r=0)", "leg 2 of the path: inf is no place"),
        ("movel(p[-0.4,0.2,0.2,0,3,0],a=0,v=0.25,r=0)", "leg 2 of the path: a must be more than 0"),
        ("movej([0,0,0,0,0,0],a=1,v=-1,r=0)", "leg 2 of the path: v must be more than 0"),
        ("movej([0,0,0,0,0,0],a=1,v=nan,r=0)", "leg 2 of the path: v must be more than 0"),
    ],
)
def test_a_path_with_a_leg_that_no_arm_can_go_moves_nothing(commanded, at, second, why):
    controller = commanded(PATH, ONE, path=a_path(to("movel", at.down), second))
    assert not controller.running
    assert (controller.arm.q == controller.begun).all()
    assert why in str(controller.events)


@pytest.mark.parametrize("place", [(-400.0, 200.0, 200.0, 0.0, math.pi, 0.0), (1e22, 0, 0, 0, 0, 0)])
@pytest.mark.parametrize("kind", ["movel", "movej"])
def test_a_path_out_of_reach_as_one_in_millimetres_is_a_protective_stop(commanded, at, kind, place):
    controller = commanded(PATH, ONE, cycles=3000, path=a_path(to("movel", at.down), to(kind, place)))
    assert controller.safety.name == "PROTECTIVE_STOP"
    assert controller.arm.steady
    assert not controller.running


@pytest.mark.parametrize("kind", ["movel", "movej"])
def test_a_path_is_stopped_midway(commanded, at, kind):
    slow = [to(kind, at.down, "a=1.2,v=0.01,r=0"), to(kind, at.pose, "a=1.2,v=0.02,r=0")]
    controller = commanded(PATH, ONE, cycles=200, path=a_path(*slow), asynchronous=1)
    assert not controller.arm.steady
    assert controller.registers.out_int[2] & 1 << 15
    controller.take({"input_int_register_0": 0})
    controller.cycle()
    controller.take({"input_double_register_0": 10.0, "input_int_register_0": STOP_L})
    for _ in range(100):
        controller.cycle()
    assert controller.running
    assert controller.arm.steady
    assert controller.registers.out_int[2] & 1 << 15 == 0


def test_a_path_is_ended_by_a_protective_stop(commanded, at):
    controller = commanded(PATH, ONE, cycles=20, path=a_path(to("movel", at.down), to("movej", at.turned)))
    controller.stop_safely("protective_stop", "a test")
    for _ in range(2600):
        controller.cycle()
    assert not controller.running
    assert controller.arm.steady
    assert controller.arm.q != pytest.approx(at.turned, abs=1e-3)
    assert controller.unlock()
    for _ in range(100):
        controller.cycle()
    assert controller.arm.steady
