"""Waits of the machine's clock."""

import threading

from stretch_bt.clock import LONGEST, RealClock

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
