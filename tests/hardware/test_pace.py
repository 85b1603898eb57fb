"""When cycles no longer follow the records, against streams whose jumps are known."""

import itertools

import pytest

from stretch_bt.hardware.ati.pace import Pace
from stretch_bt.hardware.ati.rdt import Record

#: within how many records a change is told
SOON = 10


def broken(steps, first=(1, 1)):
    """Return at which of some steps, each of records and cycles, the pace broke."""
    pace, turn = Pace(), 1 << 32
    places = itertools.accumulate(steps, lambda place, step: (place[0] + step[0], place[1] + step[1]), initial=first)
    broke = [pace.broke(Record(number % turn, cycle % turn, 0, (0,) * 6)) for number, cycle in places]
    return [k for k, one in enumerate(broke[1:]) if one]


@pytest.mark.parametrize(
    ("steps", "at"),
    [
        ([(1, 1)] * 300 + [(1, 1_000_000)] + [(1, 1)] * 300, [300]),
        ([(1, 4)] * 300 + [(1, 1)] * 300, [300]),
        ([(1, 1)] * 300 + [(1, 4)] * 300, [300]),
        ([(1, 56)] * 100 + [(1, 28)] * 100, [100]),
        ([(1, 7), (1, 8), (1, 7)] * 200, []),
        ([(1, 1), (1, 7)] * 200, []),
        ([(3, 12), (1, 4), (500, 2000)] * 100, []),
        ([(1, 4)] * 100 + [(-100, 400)] + [(1, 4)] * 100, []),
    ],
    ids=["jump", "slower", "faster", "half", "uneven", "by turns", "losses", "new stream"],
)
def test_a_jump_and_a_change_of_rate_are_told_once_and_nothing_else_is(steps, at):
    found = broken(steps)
    assert len(found) == len(at)
    assert all(one <= k < one + SOON for k, one in zip(found, at, strict=True))


def test_the_turn_of_both_numbers_to_0_is_no_jump():
    assert broken([(1, 4)] * 1000, first=(2**32 - 300, 2**32 - 900)) == []
