"""When ticks are due and how they are counted, alone and over several runs."""

import pytest

from stretch_bt.runtime.tick_grid import TickGrid


def test_deadlines_are_multiples_of_the_period():
    grid = TickGrid(0.05)
    grid.begin(1.0)
    for k in range(1000):
        assert grid.due == 1.0 + k * 0.05
        assert grid.take() == k + 1
        assert grid.leave(grid.due) <= 0.0


def test_what_was_missed_is_not_caught_up_with():
    grid = TickGrid(0.05)
    grid.begin(0.0)
    grid.take()
    assert grid.leave(0.12) == pytest.approx(0.07)
    assert grid.due == pytest.approx(0.15)
    assert grid.take() == 2


#: when a run after one that ended in tick 2, at 0.05 s, begins -> number of its first tick, when its second is due
JOINED = {
    "at once": (0.05, 2, 0.10),
    "before the next": (0.09, 2, 0.10),
    "when the next is due": (0.10, 3, 0.15),
    "after a pause": (0.62, 3, 0.65),
}


@pytest.mark.parametrize("when", JOINED)
def test_a_run_that_joins_goes_on_in_the_tick_that_is_not_over(when):
    now, number, following = JOINED[when]
    grid = TickGrid(0.05)
    grid.join(0.0)
    for _ in range(2):
        grid.take()
        grid.leave(grid.due)
    grid.join(now)
    assert grid.due <= now
    assert grid.take() == number
    assert grid.leave(now) <= 0.0, "a begin between two ticks is no lateness"
    assert grid.due == pytest.approx(following)


def test_a_grid_without_a_period_counts_every_tick():
    grid = TickGrid(0.0)
    for number in (1, 2, 3):
        grid.join(1.0)
        assert grid.take() == number
        assert grid.leave(1.0) <= 0.0
