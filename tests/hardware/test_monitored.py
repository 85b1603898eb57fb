"""What is common to all devices."""

import math
import time
from pathlib import Path
from unittest import mock

import pytest

from stretch_bt.errors import BeyondLimits, DeviceFault, InvalidInput, NoEquilibrium, NotReady, StaleReading
from stretch_bt.frames import Pose, Wrench
from stretch_bt.hardware.driver import ArmDriver, CellContext, GripperDriver, OperatorDriver
from stretch_bt.hardware.hand import Hand
from stretch_bt.hardware.interfaces import DeviceState, MotionState, Reading
from stretch_bt.hardware.journal import Relay
from stretch_bt.hardware.limits import Limits
from stretch_bt.hardware.monitored.arm import MonitoredArm
from stretch_bt.hardware.monitored.base import Watch
from stretch_bt.hardware.monitored.gripper import MonitoredGripper
from stretch_bt.hardware.monitored.operator import MonitoredOperator


class Held(ArmDriver):
    """An arm whose reading is old until it was asked for some times, as while another thread has no turn."""

    Options = None
    left = 0

    def follow(self, path, speed):
        raise NotImplementedError

    def wrench(self):
        raise NotImplementedError

    def pose(self):
        self.left -= 1
        old = 1.0 if self.left >= 0 else 0.0
        return Reading(Pose(), 0.0, time.monotonic() - old, 0)


@pytest.mark.parametrize(("streams", "asked", "fresh"), [(True, 10, True), (True, 100_000, False), (False, 1, False)])
def test_a_reading_that_is_old_is_waited_for_a_moment_where_newer_ones_come_by_themselves(streams, asked, fresh):
    limits, hand = Limits(), Hand()
    driver = type("Held", (Held,), {"streams": streams, "left": asked})(
        "arm", None, CellContext(time.monotonic, 0, Path(), hand, limits)
    )
    arm = MonitoredArm("arm", driver, Watch(time.monotonic, limits, hand, Relay()))
    arm.open()
    if fresh:
        assert time.monotonic() - arm.pose(0.2).host_time < 0.2
    else:
        with pytest.raises(StaleReading, match="the latest pose is 1 s old"):
            arm.pose(0.2)
    assert driver.left < asked - 5 or not streams


class Unbalanced(ArmDriver):
    """An arm in a simulation that has no force for where it is."""

    Options = None

    def follow(self, path, speed):
        return lambda: MotionState.MOVING

    def wrench(self):
        raise NoEquilibrium("nothing is in balance here")

    def pose(self):
        return Reading(Pose((0, 0, 0.1)), time.monotonic(), time.monotonic(), 0)

    def stop(self):
        pass


def opened(device, driver):
    """Return a driver, and the open device around it."""
    limits, hand = Limits(), Hand()
    made = driver("device", None, CellContext(time.monotonic, 0, Path(), hand, limits))
    monitored = device("device", made, Watch(time.monotonic, limits, hand, Relay()))
    monitored.open()
    return made, monitored


def test_where_there_is_no_force_a_motion_that_rises_goes_on_and_no_other():
    _, arm = opened(MonitoredArm, Unbalanced)
    assert arm.move(Pose((0, 0, 0.12)), speed=0.02, owner="up").poll() is MotionState.MOVING
    for height in (0.08, 0.0999):
        with pytest.raises(NoEquilibrium):
            arm.move(Pose((0, 0, height)), speed=0.02, owner="down").poll()


class Choosy(Unbalanced):
    """An arm that refuses its second way."""

    ways = 0
    stops = 0

    def follow(self, path, speed):
        self.ways += 1
        if self.ways == 2:
            raise BeyondLimits(self.name, "the arm cannot reach a pose on the way")
        return super().follow(path, speed)

    def wrench(self):
        return Reading(Wrench((0, 0, 0), (0, 0, 0)), time.monotonic(), time.monotonic(), 0)

    def stop(self):
        self.stops += 1


def test_a_way_that_is_refused_takes_nothing_from_the_motion_before():
    driver, arm = opened(MonitoredArm, Choosy)
    first = arm.move(Pose((0, 0, 0.12)), speed=0.02, owner="a")
    with pytest.raises(BeyondLimits):
        arm.move(Pose((0, 0, 0.2)), speed=0.02, owner="b")
    assert first.poll() is MotionState.MOVING
    first.stop()
    assert (first.ended, driver.stops) == (MotionState.STOPPED, 1)


class Numb(GripperDriver):
    """A gripper that no longer knows where its fingers are."""

    Options = None
    knows = True
    stops = 0

    def move(self, opening, speed):
        return lambda: MotionState.MOVING

    def opening(self):
        now = time.monotonic()
        return Reading(0.06 if self.knows else math.nan, now, now, 0)

    def stop(self):
        self.stops += 1


def test_fingers_that_are_nowhere_are_within_no_limit():
    """NaN is past no limit, and was once reported as ok."""
    driver, gripper = opened(MonitoredGripper, Numb)
    motion = gripper.move(0.07, speed=0.02, owner="a")
    assert motion.poll() is MotionState.MOVING
    driver.knows = False
    with pytest.raises(
        DeviceFault, match=r"its driver broke .*reading is nan; where there is no opening it raises NoAnswer"
    ):
        motion.poll()
    with pytest.raises(NotReady, match="in fault"):
        gripper.move(0.06, speed=0.02, owner="a")


class Listed(Relay):
    """A journal that keeps the names of commands."""

    def __init__(self):
        self.names = []

    def command(self, device, name, arguments, owner):
        self.names.append(name)


@pytest.mark.parametrize("owner", [None, "", " ", "main//press", "main/", 7, "main/\ud800", "main\n/press"])
@pytest.mark.parametrize(
    ("device", "driver", "start"),
    [
        (MonitoredArm, ArmDriver, lambda arm, owner: arm.move(Pose((0, 0, 0.12)), speed=0.02, owner=owner)),
        (MonitoredArm, ArmDriver, lambda arm, owner: arm.follow([Pose((0, 0, 0.12))], speed=0.02, owner=owner)),
        (MonitoredGripper, GripperDriver, lambda gripper, owner: gripper.move(0.06, speed=0.02, owner=owner)),
        (MonitoredGripper, GripperDriver, lambda gripper, owner: gripper.activate(owner=owner)),
        (MonitoredOperator, OperatorDriver, lambda operator, owner: operator.mount("sphere", 0.01, owner=owner)),
        (MonitoredOperator, OperatorDriver, lambda operator, owner: operator.confirm("go", owner=owner)),
    ],
)
def test_an_owner_that_is_no_path_is_refused_before_anything_is_asked_of_the_driver(device, driver, start, owner):
    limits, hand, journal = Limits(), Hand(), Listed()
    idle = mock.create_autospec(driver, instance=True)
    idle.claimed = lambda: None
    found = device("it", idle, Watch(time.monotonic, limits, hand, journal))
    found.open()
    before = len(idle.method_calls)
    with pytest.raises(InvalidInput, match=r"it: a motion's owner is the path .*; write owner=self.path"):
        start(found, owner)
    assert journal.names == []
    assert len(idle.method_calls) == before


class Elsewhere(Unbalanced):
    """An arm that says that it is done, and has gone nowhere."""

    def follow(self, path, speed):
        return lambda: MotionState.DONE

    def wrench(self):
        return Reading(Wrench((0.0, 0.0, 0.0)), time.monotonic(), time.monotonic(), 1)


class Foretold(Numb):
    """Fingers whose readings come out of the future."""

    def opening(self):
        later = time.monotonic() + 1e3
        return Reading(0.06, later, later, 1)


class Bare(Unbalanced):
    """An arm whose force is a number."""

    def wrench(self):
        return Reading(3.0, time.monotonic(), time.monotonic(), 1)


def raised(arm):
    arm.move(arm.pose(1.0).value.moved(z=0.01), speed=0.1, owner="a").poll()


def opened_wider(gripper):
    gripper.move(0.07, speed=0.02, owner="a").poll()


def felt(arm):
    arm.wrench(1.0)


@pytest.mark.parametrize(
    ("kind", "driver", "asked", "said"),
    [
        (MonitoredArm, Elsewhere, raised, "says that the motion is done, and the hand is 10.0 mm from its end"),
        (MonitoredGripper, Foretold, opened_wider, "the time of a driver's opening is 1e[+]03 s ahead of the clock"),
        (MonitoredArm, Bare, felt, r"wrench\(\) returns a Reading of a Wrench, not of 3.0"),
    ],
)
def test_a_driver_that_tells_what_cannot_be_is_in_fault(kind, driver, asked, said):
    """They were SUCCESS, or an error of the node that asked."""
    _, device = opened(kind, driver)
    with pytest.raises(DeviceFault, match=said):
        asked(device)
    assert device.state is DeviceState.FAULT


def test_a_wrench_is_of_three_numbers():
    for given in (3.0, (1.0, 2.0), (0.0, 0.0, math.nan)):
        with pytest.raises(InvalidInput, match="three finite numbers of force"):
            Wrench(given)


@pytest.mark.parametrize(
    ("kind", "driver", "ask", "said"),
    [
        (
            MonitoredGripper,
            Numb,
            lambda g: g.move("60 mm", speed=0.1, owner="a"),
            "opening must be a finite number, m, not '60 mm'",
        ),
        (
            MonitoredArm,
            Elsewhere,
            lambda a: a.move((0, 0, 0.3), speed=0.1, owner="a"),
            r"it goes to a Pose, not to \(0, 0, 0.3\)",
        ),
        (MonitoredArm, Elsewhere, lambda a: a.follow([Pose(), 3], speed=0.1, owner="a"), "it goes to a Pose, not to 3"),
        (MonitoredArm, Elsewhere, lambda a: a.move(Pose(), speed="fast", owner="a"), "above 0 m/s, not 'fast'"),
    ],
)
def test_arguments_of_another_kind_are_refused_by_their_names(kind, driver, ask, said):
    _, device = opened(kind, driver)
    with pytest.raises(InvalidInput, match=said):
        ask(device)


class Arrives(Choosy):
    """An arm that refuses its second way, and is soon where the first one leads."""

    height = 0.1

    def follow(self, path, speed):
        super().follow(path, speed)
        self.height = path[-1].height
        return lambda: MotionState.DONE if self.ways > 1 else MotionState.MOVING

    def pose(self):
        now = time.monotonic()
        return Reading(Pose((0, 0, self.height)), now, now, 0)


def test_a_motion_is_held_against_its_own_end_after_another_was_refused():
    """It was held against the refused one's, which was a fault that stays."""
    _, arm = opened(MonitoredArm, Arrives)
    first = arm.move(Pose((0, 0, 0.102)), speed=0.02, owner="a")
    with pytest.raises(BeyondLimits):
        arm.move(Pose((0, 0, 0.2)), speed=0.02, owner="b")
    assert first.poll() is MotionState.DONE
    assert arm.fault is None


class Blind(Choosy):
    """An arm that nobody can look at while it moves."""

    def follow(self, path, speed):
        def poll():
            raise NoEquilibrium("nothing is in balance here")

        return poll


def test_a_motion_that_cannot_be_looked_at_is_stopped_where_its_owner_leaves_it():
    driver, arm = opened(MonitoredArm, Blind)
    motion = arm.move(Pose((0, 0, 0.12)), speed=0.02, owner="a")
    arm.release("a")
    assert (motion.ended, driver.stops) == (MotionState.STOPPED, 1)


class Stands(Choosy):
    """An arm whose pose no longer changes, nor its time."""

    since = 0.0

    def pose(self):
        return Reading(Pose((0, 0, 0.1)), 0.0, time.monotonic() - self.since, 0)


def test_an_arm_without_a_new_pose_does_not_move():
    driver, arm = opened(MonitoredArm, Stands)
    motion = arm.move(Pose((0, 0, 0.12)), speed=0.02, owner="a")
    driver.since = 1.0
    with pytest.raises(StaleReading, match=r"moved without a new pose for 0\.5 s"):
        motion.poll()
    assert driver.stops == 1
    driver, arm = opened(MonitoredArm, Stands)
    driver.since = 1.0
    with pytest.raises(StaleReading, match=r"latest pose is 1 s old, at most 0\.5 s to move"):
        arm.move(Pose((0, 0, 0.12)), speed=0.02, owner="a")
    assert driver.ways == 0
