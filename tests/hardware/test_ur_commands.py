"""What the script of the client makes of commands that no arm can follow, cycle by cycle, without a client."""

import math

import numpy as np
import pytest

from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.script import ControlScript, parse_script
from stretch_bt.hardware.emulators.ur.stand_in import Ur5eStandIn

MOVE_J, MOVE_L, SPEED_J, SPEED_L, PATH = 1, 3, 9, 10, 45
LINE = "def rtde_control():\n# float register offset\n0\n# int register offset\n0\nmovel(p[0,0,0.3,0,3,0],a=0,v=1,r=0)"
ONE = [0.1] * 6
#: a line to the side, and a turn of the hand about it
TURNED = [-0.4, 0.2, 0.2, 0.0, math.pi, 0.0]
#: limit of a joint, rad/s, and some rounding
FASTEST = math.radians(180) * 1.002


@pytest.fixture
def commanded():
    """Return the controller after a command with its doubles, and some cycles."""

    def run(command, doubles, cycles=100, path=()):
        controller = Ur5eStandIn("127.0.0.1", StandInWorld()).controller
        controller.load(ControlScript(controller, 0, list(path)).run(), 0.0)
        for _ in range(30):
            controller.cycle()
        controller.begun = controller.arm.q.copy()
        controller.take({f"input_double_register_{k}": float(value) for k, value in enumerate(doubles)})
        controller.take({"input_int_register_0": command})
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
