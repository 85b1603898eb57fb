"""Positions that fingers cannot have: single ones are asked for again, and many are a loss."""

import itertools
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardware.robotiq.registers import ActivationStage, ObjectStatus, Status
from stretch_bt.hardware.robotiq.screened_wire import ScreenedWire
from stretch_bt.hardware.wire_thread import WireError

PERIOD = 1 / 30


class Answers:
    """A gripper that answers with given positions, and counts how often it was asked."""

    exchanges = 1

    def __init__(self, positions):
        self.positions, self.asked = iter(positions), 0

    def read(self):
        self.asked += 1
        return Status(True, True, ActivationStage.ACTIVE, ObjectStatus.MOVING, 0, 0, next(self.positions))

    def connect(self): ...

    close = go = hold = reset = activate = connect


def believed(positions, count):
    """Return the positions that are believed, of so many readings a period apart, and how often the gripper was asked."""
    answers, clock = Answers(positions), [0.0]
    wire = ScreenedWire(answers, lambda: clock[0])
    found = []
    for k in range(count):
        clock[0] = k * PERIOD
        found.append(wire.read().position)
    return found, answers.asked


@given(st.integers(0, 255), st.lists(st.integers(-15, 15), max_size=40))
def test_fingers_that_move_are_believed_at_once(first, steps):
    places = [min(max(place, 0), 255) for place in itertools.accumulate(steps, initial=first)]
    assert believed(places, len(places)) == (places, len(places))


@given(st.integers(60, 180), st.integers(0, 255))
def test_a_single_position_that_jumps_is_never_believed(place, wild):
    found, _ = believed([place, wild, place, place, place, place], 4)
    assert all(abs(one - place) <= 32 for one in found)


def test_what_is_confirmed_is_believed():
    assert believed([10, 200, 201, 202], 3)[0] == [10, 201, 202]


def test_positions_that_agree_with_nothing_are_a_loss():
    with pytest.raises(WireError, match="agree with nothing: 255, 130, 200, 90"):
        believed([10, 255, 130, 200, 90], 2)


def test_the_rest_of_the_wire_is_as_it_is():
    answers = Answers([])
    wire = ScreenedWire(answers, lambda: 0.0)
    assert (wire.connect, wire.go, wire.hold) == (answers.connect, answers.go, answers.hold)


@pytest.mark.parametrize(
    "kind", ["robotiq-rtu", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("robotiq-tcp", "urcap"))]
)
def test_some_wild_positions_do_no_harm(make_cell, kind):
    cell = make_cell(kind)
    gripper = cell.devices["gripper"]
    here = gripper.opening(1e6).value
    cell.stand_in.inject("wild", {"part": 0.15})
    number = gripper.opening(1e6).sequence
    while (reading := gripper.opening(1e6)).sequence < number + 60:
        assert abs(reading.value - here) < 0.02
        time.sleep(0.002)
