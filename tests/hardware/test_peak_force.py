"""The largest force before an arm stands: the formula against a force followed in small steps, and against the stand-in's arm."""

import itertools
import math
import time
from collections import deque
from contextlib import suppress
from dataclasses import replace

import pytest
from waiting import LIMIT

from stretch_bt.errors import DeviceFault
from stretch_bt.frames import Pose
from stretch_bt.hardware.cell import open_cell
from stretch_bt.hardware.cell_file import load_cell
from stretch_bt.hardware.emulators.stand_in_world import StandInWorld
from stretch_bt.hardware.emulators.ur.stand_in import Ur5StandIn
from stretch_bt.hardware.interfaces import MotionState
from stretch_bt.hardware.peak_force import Stopping, fastest_for, peak_force

#: of an arm that averages its force, of one that does not, and of one without a limit for single readings
STOPPINGS = {
    "averaged": Stopping(averaged=0.128, single=40.0, delay=0.024, deceleration=2.0, late=0.2, lag=0.05),
    "single": Stopping(averaged=0.0, single=math.inf, delay=0.012, deceleration=5.0, late=0.2, lag=0.05),
    "slow": Stopping(averaged=0.5, single=math.inf, delay=0.05, deceleration=0.5, late=1.0, lag=0.2),
}
SPEEDS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.25)
STIFFNESSES = (1e3, 5e3, 20e3, 200e3)
FORCE = 20.0
#: of the computed peak that the stand-in's arm comes to at least, and at most
LEAST_PART, MOST_PART = 0.25, 1.05


def followed(speed, stiffness, limit, stopping, *, late=False):
    """Return the largest force of a hand that is followed in small steps."""
    step = min(1e-4, 0.02 * limit / (stiffness * speed))
    window = deque([0.0] * max(round(stopping.averaged / step), 1))
    total = force = place = 0.0
    while total / len(window) <= limit and force <= stopping.single:
        place += speed * step
        force = stiffness * place
        total += force - window.popleft()
        window.append(force)
    place += speed * (stopping.delay + (stopping.late if late else 0.0))
    last = place + speed * stopping.lag
    while speed > 0:
        place += speed * step
        speed -= stopping.deceleration * step
    return stiffness * (max(place, last) if late else place)


@pytest.mark.parametrize("stopping", STOPPINGS.values(), ids=STOPPINGS)
def test_it_is_the_force_of_a_hand_that_is_followed_in_small_steps(stopping):
    for speed, stiffness in itertools.product(SPEEDS, STIFFNESSES):
        found = peak_force(speed, stiffness, FORCE, stopping)
        assert found.stopped == pytest.approx(followed(speed, stiffness, FORCE, stopping), rel=0.03)
        assert found.late == pytest.approx(followed(speed, stiffness, FORCE, stopping, late=True), rel=0.03)


@pytest.mark.parametrize("stopping", STOPPINGS.values(), ids=STOPPINGS)
def test_it_grows_with_speed_stiffness_and_whatever_makes_the_arm_later(stopping):
    for speed, stiffness in itertools.product(SPEEDS, STIFFNESSES):
        here = peak_force(speed, stiffness, FORCE, stopping)
        assert FORCE < here.stopped <= here.late
        for other in (
            peak_force(1.1 * speed, stiffness, FORCE, stopping),
            peak_force(speed, 1.1 * stiffness, FORCE, stopping),
            peak_force(speed, stiffness, FORCE, replace(stopping, delay=0.2)),
            peak_force(speed, stiffness, FORCE, replace(stopping, deceleration=0.2)),
        ):
            assert other.stopped > here.stopped
            assert other.late >= here.late
        assert peak_force(speed, stiffness, FORCE, replace(stopping, averaged=1.0)).stopped >= here.stopped
        assert peak_force(speed, stiffness, FORCE, replace(stopping, late=5.0)).late > here.late


@pytest.mark.parametrize("stopping", STOPPINGS.values(), ids=STOPPINGS)
def test_the_fastest_for_a_peak_comes_to_it_and_no_faster_one_does(stopping):
    for stiffness, peak in itertools.product(STIFFNESSES, (20.5, 30.0, 75.0, 300.0)):
        fast = fastest_for(peak, stiffness, FORCE, stopping, 0.25)
        assert peak_force(fast, stiffness, FORCE, stopping).stopped <= peak
        assert fast == 0.25 or peak_force(1.001 * fast, stiffness, FORCE, stopping).stopped > peak
    assert fastest_for(FORCE, 1e3, FORCE, stopping, 0.25) is None


# --- on the stand-in

#: what the connection does meanwhile: holds readings back for almost `lost_after`, or sends no new one from the touch on
FAILS = {"late": {"delay": 0.17}, "repeat": {}}
PRESSES = [(0.02, 20e3), (0.05, 5e3), (0.05, 200e3), (0.1, 20e3), (0.25, 200e3)]
#: presses that the remaining one stands for
BETWEEN = {PRESSES[0], PRESSES[1], PRESSES[3], PRESSES[4]}
WALL = 0.15


@pytest.fixture(scope="module")
def behind(own_hosts):
    """The stand-in of a UR5."""
    made = Ur5StandIn(next(own_hosts), StandInWorld())
    made.start()
    yield made
    made.stop()


@pytest.fixture
def pressed(behind, tmp_path, write_cell):
    """Press a wall with the default deadlines, over a connection that fails or not: the force at rest, and what was computed."""
    deadlines = {"watchdog": "5 Hz", "lost_after": "200 ms", "heartbeat": "500 ms"}
    spec = load_cell(write_cell(tmp_path, "ur", "rtde", f"{behind.host}:30004", **deadlines))

    def press(speed, stiffness, fails):
        behind.clear()
        cell = open_cell(spec, now=time.monotonic)
        try:
            for _ in moved(cell, WALL + 0.015 + speed**2, 0.25):  # from there it has its speed before it touches
                pass
            behind.inject("wall", {"height": WALL, "stiffness": stiffness})
            with pytest.raises(DeviceFault, match=r"nothing new|force [\d.]+ N"):
                meet(cell, speed, fails)
        finally:
            cell.close()
        stands(behind)
        return stiffness * (WALL - behind.hand().height), peak_force(
            speed, stiffness, FORCE, spec.devices["arm"].options.stopping(spec.limits)
        )

    def meet(cell, speed, fails):
        before = WALL + (0.3 if fails == "late" else 0.01) * speed
        for _ in moved(cell, 0.03, speed):
            if fails is not None and behind.hand().height < before and behind.faults.shown(fails) is None:
                behind.inject(fails, FAILS[fails])

    yield press
    behind.clear()


def moved(cell, height, speed):
    """Move the hand, and yield at each poll."""
    motion = cell.devices["arm"].move(Pose((0.0, 0.0, height)), speed=speed, owner="a")
    while motion.poll() is MotionState.MOVING:
        yield
        time.sleep(0.001)


def stands(stand_in):
    """Wait until the arm has stood for a while of its own time."""
    end = time.monotonic() + LIMIT
    while (state := stand_in.state())["time"] < state["moved"] + 0.15:
        assert time.monotonic() < end, "the arm does not stand"
        time.sleep(0.01)


def within(pressed, least, most):
    """Press until a peak is within bounds: a busy machine makes the arm later than it is, and ends motions of its own."""
    end, found = time.monotonic() + LIMIT, []
    while time.monotonic() < end:
        with suppress(DeviceFault, AssertionError):
            found.append(pressed())
            measured, computed = found[-1]
            if least(computed) <= measured <= most(computed):
                return
    raise AssertionError(found)


@pytest.mark.parametrize(
    ("speed", "stiffness"),
    [pytest.param(*press, marks=[pytest.mark.slow] if press in BETWEEN else []) for press in PRESSES],
)
def test_the_stand_ins_arm_comes_to_what_is_computed_and_not_beyond(pressed, speed, stiffness):
    within(
        lambda: pressed(speed, stiffness, None),
        lambda computed: LEAST_PART * computed.stopped,
        lambda computed: MOST_PART * computed.stopped,
    )


@pytest.mark.parametrize("fails", ["late", pytest.param("repeat", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("speed", "stiffness"), [PRESSES[2], pytest.param(*PRESSES[3], marks=pytest.mark.slow)])
def test_over_a_connection_that_fails_it_comes_to_no_more_than_is_computed_for_that(pressed, speed, stiffness, fails):
    within(
        lambda: pressed(speed, stiffness, fails),
        lambda computed: (LEAST_PART if fails == "late" else 0.02) * computed.late,
        lambda computed: MOST_PART * computed.late,
    )
