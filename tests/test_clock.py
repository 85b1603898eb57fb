"""Waits of the machine's clock, and of the virtual one that goes no faster."""

import threading
import time

import numpy as np
import pytest

from stretch_bt.clock import JITTER, LONGEST, PacedClock, RealClock, VirtualClock
from stretch_bt.errors import InvalidInput

#: how long waits may go on before one is taken to have no end, s
_ENDS = 60.0
#: a queue of the standard library, waited on like this, hung within some thousands
_WAITS = 60_000


def test_first_waits_end_where_their_time_is_over_as_they_begin():
    def first_waits():
        for _ in range(_WAITS):
            clock = RealClock()
            clock.now = float
            clock.wait_until(1e-9)

    waiting = threading.Thread(target=first_waits, daemon=True)
    waiting.start()
    waiting.join(_ENDS)
    assert not waiting.is_alive()


def test_a_wake_ends_one_wait_however_often_it_came():
    clock = RealClock()
    for _ in range(3):
        clock.wake()
    before = clock.now()
    clock.wait_until(before + LONGEST)  # ended by the wakes
    woken = clock.now()
    clock.wait_until(woken + LONGEST / 2)
    assert clock.now() - woken >= LONGEST / 2


def wait(clock, deadline):
    while not clock.reached(deadline):
        clock.wait_until(deadline)


@pytest.mark.parametrize("work", [0.0, 0.004, 0.03], ids="work {} s".format)
def test_a_paced_clock_is_at_each_deadline_and_never_ahead_of_the_machine(work):
    clock = PacedClock(VirtualClock())
    begun = time.monotonic()
    for tick in range(1, 6):
        time.sleep(work)
        wait(clock, tick * 0.01)
        assert clock.now() == tick * 0.01
        assert clock.now() <= time.monotonic() - begun


def test_a_paced_clock_does_not_catch_up_with_a_tick_that_took_long():
    clock = PacedClock(VirtualClock())
    time.sleep(0.2)
    wait(clock, 0.01)
    begun = time.monotonic()
    wait(clock, 0.11)
    assert time.monotonic() - begun >= 0.1 - JITTER


def test_a_wake_ends_the_wait_of_a_paced_clock_where_it_stands():
    clock = PacedClock(VirtualClock())
    clock.wake()
    clock.wait_until(60.0)
    assert clock.now() == 0.0
    assert not clock.reached(60.0)


@pytest.mark.parametrize("seconds", [-0.7, float("nan"), float("inf"), "1 s", None])
def test_a_clock_goes_on_by_a_number_of_seconds(seconds):
    clock = VirtualClock()
    with pytest.raises(InvalidInput, match="a number of seconds from 0 on"):
        clock.advance(seconds)
    clock.advance(np.float32(0.5))
    assert type(clock.now()) is float
