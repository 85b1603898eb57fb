"""The parts of the arm's driver by themselves: messages, limits, setpoints, reach."""

import socket
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from waiting import broken_off, eventually

from stretch_bt.errors import BeyondLimits
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.channel import Channel, ChannelClosed
from stretch_bt.hardware.driver import CellContext
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.messages import Lost, Message
from stretch_bt.hardware.motion.path import PosePath
from stretch_bt.hardware.ur.arm import MOST_POSES
from stretch_bt.hardware.ur.force_filter import HandForce
from stretch_bt.hardware.ur.guard import beyond, safety_stop
from stretch_bt.hardware.ur.messages import CODEC, ArmState, Beat, Engaged, Follow, Stop
from stretch_bt.hardware.ur.reach import Reach
from stretch_bt.hardware.ur.ride import Ride

HAND = Pose((0.0, 0.0, 0.3), (np.pi, 0.0, 0.0))
BASE = Pose((-0.5, 0.0, 0.0))
UP = (np.pi, -1.6, 1.8, -1.8, -np.pi / 2, 0.0)


@pytest.fixture(scope="module")
def lab():
    """Settings of the shipped cell of a UR5."""
    spec = load_cell("lab_ur5")
    cell = CellContext(lambda: 0.0, 0, spec.path.parent, Hand(spec.hand), spec.limits)
    return spec.devices["arm"].options.settings(cell)


SIX = st.tuples(*[st.floats(-1e9, 1e9)] * 6)
MESSAGES = st.one_of(
    st.builds(Beat, st.none() | st.floats(-1, 1), st.floats(0, 1e9)),
    st.builds(Follow, st.integers(0, 1 << 60), st.lists(SIX, max_size=4).map(tuple), st.floats(0.01, 1)),
    st.builds(Engaged, st.integers(0, 1 << 60), st.none() | st.text(st.characters(codec="utf-8")), st.booleans()),
    st.builds(ArmState, st.floats(0, 1e9), st.integers(0), SIX, SIX, SIX, SIX, st.booleans()),
)


@settings(max_examples=30, deadline=None)
@given(st.lists(MESSAGES, max_size=4))
def test_messages_arrive_as_they_were_sent(messages):
    one, other = socket.socketpair()
    with one, other:
        here, there = Channel(one, CODEC), Channel(other, CODEC)
        for message in messages:
            here.send(message)
        assert there.drain() == messages


def test_the_longest_path_fits_into_one_message():
    one, other = socket.socketpair()
    with one, other:
        here, there = Channel(one, CODEC, 5.0), Channel(other, CODEC)
        message, came = Follow(1, ((-1.2345678901234567e-100,) * 6,) * MOST_POSES, 0.02), []
        sender = threading.Thread(target=here.send, args=(message,))
        sender.start()
        eventually(lambda: came.extend(there.drain()) or came)
        sender.join()
        assert came == [message]


def test_a_longer_path_is_refused_and_the_arm_is_as_it_was(make_cell):
    """Its message was one without an end, and the arm was lost."""
    arm = make_cell("ur").devices["arm"]
    here = arm.pose(1.0).value
    path = [Pose((here.position[0], here.position[1], here.position[2] + 1e-6 * k), here.rotation) for k in range(9000)]
    with pytest.raises(BeyondLimits, match="a path takes at most 5000 poses, and this one has 9000; leave out"):
        arm.follow(path, speed=0.02, owner="a")
    assert arm.follow(path[:4000:1000], speed=0.02, owner="a").poll() is MotionState.MOVING


@settings(deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_messages_or_the_end(data):
    one, other = socket.socketpair()
    with other:
        there = Channel(other, CODEC)
        with one:
            one.sendall(data)
        try:
            while True:
                assert all(isinstance(message, Message) for message in there.drain())
        except ChannelClosed as error:
            assert str(error)


def test_what_was_said_before_the_end_is_read_first():
    """Also where the other side ends with something unread, which resets the connection."""
    one, other = socket.socketpair()
    with other:
        there = Channel(other, CODEC)
        with one:
            there.send(Stop(1))
            Channel(one, CODEC).send(Lost("unplugged", missing=False))
        assert there.drain() == [Lost("unplugged", missing=False)]
        with pytest.raises(ChannelClosed, match="gone"):
            there.drain()


def test_a_side_that_does_not_read_counts_as_gone():
    one, other = socket.socketpair()
    with one, other:
        here = Channel(one, CODEC, patience=0.05)
        with pytest.raises(ChannelClosed, match="takes no messages"):
            here.send(Lost("x" * (1 << 24), missing=False))


def test_settings_and_states_come_back_from_their_messages(lab):
    state = ArmState(1.5, 3, UP, (0.1,) * 6, (0.0,) * 6, (1.0,) * 6, True, 4, MotionState.MOVING, "why", True)
    for message in (lab, state):
        assert CODEC.decode(CODEC.encode(message)) == message


# (place, speed, force, height of contact, part of what is said)
BEYOND = [
    ((0.0, 0.0, 0.1), 0.05, 1.0, None, None),
    ((0.1515, 0.0, 0.1), 0.05, 1.0, None, None),
    ((0.153, 0.0, 0.1), 0.05, 1.0, None, "x 153 mm is past"),
    ((0.0, -0.2, 0.1), 0.05, 1.0, None, "y -200 mm"),
    ((0.0, 0.0, 0.01), 0.05, 1.0, None, "height 10 mm is past the limits of the cell, 20 mm to 200 mm"),
    ((0.0, 0.0, 0.05), 0.05, 1.0, 0.06, None),
    ((0.0, 0.0, 0.035), 0.05, 1.0, 0.06, "depth 25 mm is past the limit of the cell, at most 20 mm"),
    ((0.0, 0.0, 0.1), 0.2, 1.0, None, "speed 200 mm/s"),
    ((0.0, 0.0, 0.1), 0.057, 1.0, None, None),
    ((0.0, 0.0, 0.0999), 0.055, 1.0, None, None),
    (
        (0.0, 0.0, 0.0999),
        0.057,
        1.0,
        None,
        "speed 57 mm/s is past the limit of the cell, at most 30 mm/s below a height of 100 mm",
    ),
    ((0.0, 0.0, 0.1), 0.05, 20.5, None, "force 20.5 N is past the limit of the cell, at most 20 N"),
    ((0.0, 0.0, 0.1), 0.05, float("nan"), None, "force nan"),
    ((0.0, 0.0, 0.1), 0.05, HandForce(1.0, 39.9), None, None),
    (
        (0.0, 0.0, 0.1),
        0.05,
        HandForce(1.0, 40.1),
        None,
        "force 40.1 N in one sample is past 40 N, which no noise reaches",
    ),
]


@pytest.mark.parametrize(("place", "speed", "force", "contact", "said"), BEYOND)
def test_measured_values_are_compared_with_the_limits(lab, place, speed, force, contact, said):
    on_hand = force if isinstance(force, HandForce) else HandForce(force, force)
    found = beyond(lab, place, speed, on_hand, contact)
    assert (found is None) if said is None else (said in found)


@given(st.integers(0, (1 << 12) - 1))
def test_any_safety_bit_but_the_harmless_ones_is_a_stop(bits):
    assert (safety_stop(bits) is None) is (bits & ~0b100000000011 == 0)


def after(ride, seconds):
    """Return a ride as it is some time after its begin."""
    return replace(ride, gone=seconds)


PLACE = st.tuples(*[st.floats(-0.2, 0.2)] * 3).map(lambda p: Pose(p))


@settings(max_examples=30, deadline=None)
@given(st.lists(PLACE, min_size=2, max_size=4), st.floats(0.02, 0.25), st.floats(0.05, 2.0))
def test_setpoints_go_from_begin_to_end_no_faster_than_asked(poses, speed, acceleration):
    ride = Ride.through(poses, speed, acceleration, 0.001)
    long = 2.1 / speed + 10.0
    times = np.linspace(0.0, long, 200)
    places = np.array([after(ride, t).setpoint.position for t in times])
    assert places[0] == pytest.approx(poses[0].position)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps.max() <= speed * times[1] * (1 + 1e-9)
    assert places[-1] == pytest.approx(poses[-1].position, abs=1e-9)
    assert after(ride, long).judge(poses[-1]) is MotionState.DONE


def test_after_a_pause_the_setpoint_goes_on_from_where_it_was():
    ride, gone = Ride.through([Pose(), Pose((0.1, 0.0, 0.0))], 0.05, 0.5, 0.001), []
    for now in (7.0, 7.008, 7.016, 7.216, 7.224):
        ride = ride.at(now, 0.024)
        gone.append(ride.gone)
    assert gone == pytest.approx([0.0, 0.008, 0.016, 0.040, 0.048])


def test_a_hand_that_lags_or_ends_elsewhere_is_told():
    ride = Ride.through([Pose(), Pose((0.1, 0.0, 0.0))], 0.05, 0.5, 0.001)
    assert after(ride, 1.0).judge(after(ride, 0.9).setpoint) is MotionState.MOVING
    assert "does not follow" in after(ride, 1.0).judge(Pose())
    near, off = Pose((0.0995, 0.0, 0.0)), Pose((0.095, 0.0, 0.0))
    assert after(ride, 2.2).judge(near) is MotionState.MOVING
    assert after(ride, 3.0).judge(near) is MotionState.DONE
    assert "did not arrive: it is 5.0 mm off" in after(ride, 3.0).judge(off)


@pytest.mark.parametrize("speed", [0.003, 0.005, 0.05, 0.25])
def test_a_hand_that_stands_still_anywhere_on_its_way_is_told_as_soon(speed):
    """Where little of the way is left it is not behind by much, but then it has to settle: that together took 1.1 s."""
    ride = Ride.through([Pose(), Pose((0.02, 0.0, 0.0))], speed, 0.5, 0.0005)
    end, soon = ride.profile.duration, max(0.8, 0.35 + 0.0015 / speed)
    for since in np.linspace(0.0, end, 97)[1:]:
        stands = after(ride, since).setpoint
        if np.linalg.norm(np.subtract(stands.position, (0.02, 0.0, 0.0))) <= ride.tolerance:
            continue
        times = since + np.arange(0.0, 3.0, 0.01)
        verdict, when = next((v, t) for t in times if (v := after(ride, t).judge(stands)) is not MotionState.MOVING)
        assert "behind" in verdict or "did not arrive" in verdict
        assert when - since <= soon


@pytest.mark.parametrize("turn", [0.3, np.pi, -3.0])
def test_half_a_turn_is_the_same_whichever_way_it_is_written(turn):
    ride = after(Ride.through([Pose(), Pose(rotation=(0.0, 0.0, turn))], 0.05, 0.5, 0.001), 100.0)
    assert ride.judge(Pose(rotation=(0.0, 0.0, turn - 2 * np.pi))) is MotionState.DONE
    assert "did not arrive" in ride.judge(Pose(rotation=(0.0, 0.0, turn - 0.1)))


def test_a_hand_that_is_half_a_turn_round_goes_straight_whatever_sign_is_measured():
    """The sign of its rotation vector is decided by noise; a path the long way round would turn the wrist by a whole round."""
    here, there = Pose((0.0, 0.0, 0.1), (0.0, 0.0, -3.14159)), Pose((0.0, 0.0, 0.14), (0.0, 0.0, 3.14159))
    ride = Ride.through([here, there], 0.05, 0.5, 0.001)
    halfway = after(ride, 0.45).setpoint.matrix()
    assert halfway == pytest.approx(here.matrix(), abs=1e-4)
    assert after(ride, 100.0).judge(there) is MotionState.DONE
    start = (np.pi, -1.6, 1.8, -1.8, -np.pi / 2, 3.0)
    reach = Reach("ur5", BASE, HAND, joint_speed=1.0, margin=0.05)
    assert reach.obstacle(PosePath([here, there]), 0.05, start) is None


@pytest.mark.parametrize("model", ["ur5", "ur5e"])
def test_reach_says_what_keeps_the_arm_from_a_path(model):
    reach = Reach(model, BASE, HAND, joint_speed=1.0, margin=0.05)
    down = PosePath([Pose((0.0, 0.0, 0.2)), Pose((0.0, 0.0, 0.1))])
    assert reach.obstacle(down, 0.1, UP) is None
    assert reach.obstacle(down, 5.0, UP).reason.endswith("go slower")
    assert reach.obstacle(down, 5.0, UP).concerns == ("speed", "contact_speed")
    turned_round = PosePath([Pose((0.0, 0.0, 0.2)), Pose((0.0, 0.0, 0.2), (0.0, 0.0, 1.5))])
    assert reach.slowed(down, 0.1, UP) == 0.1
    assert reach.obstacle(turned_round, 0.2, UP) is None
    assert reach.slowed(turned_round, 0.2, UP) == pytest.approx(0.1, rel=0.01)  # by the lever of 0.1 m: 1 rad/s
    away = PosePath([Pose((0.0, 0.0, 0.2)), Pose((0.6, 0.0, 0.2))])
    assert reach.obstacle(away, 0.01, UP).reason.startswith("the pose")
    assert reach.obstacle(away, 0.01, UP).concerns == ()
    turned = tuple(np.add(UP, [0, 0, 0, 0, 0, 2 * np.pi]))
    spun = PosePath(
        [Pose((0.0, 0.0, 0.2)), Pose((0.0, 0.0, 0.2), (0.0, 0.0, -1.5)), Pose((0.0, 0.0, 0.2), (0.0, 0.0, -3.0))]
    )
    assert any(
        "two rounds" in getattr(reach.obstacle(spun, 0.01, start), "reason", "")
        for start in (turned, tuple(np.subtract(turned, 1e-9)))
    )


def test_a_cell_without_payload_leaves_that_of_the_pendant(lab):
    assert lab.payload == (1.6, 0.0, 0.0, 0.11)
    assert CODEC.decode(CODEC.encode(replace(lab, payload=None))).payload is None


def test_ctrl_c_while_the_arm_is_opened_leaves_no_process(stand_in, live_cell):
    behind, places = stand_in("ur")
    behind.inject("freeze")
    cell = load_cell(live_cell("ur", "rtde", places["rtde"]))

    def begun():
        return [thread for thread in threading.enumerate() if thread.name == "supervisor of arm"]

    def all_begun():
        eventually(begun)
        time.sleep(0.5)  # its process, too
        return True

    with broken_off(all_begun):
        open_cell(cell, now=time.monotonic)
    assert not begun()
