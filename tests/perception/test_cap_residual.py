"""By how much the caps of a lump differ."""

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned
from stretch_bt.perception.cap import Cap, cap_residual


def test_caps_that_are_one_without_noise_do_not_differ():
    cap = Cap(np.zeros((15, 15)), 0.0)
    found = cap_residual([cap, cap])
    assert (found.value, found.sd) == (0.0, 0.0)


def test_noise_alone_is_taken_off_and_stays_in_the_deviation():
    noise, chance = 1e-4, np.random.default_rng(5)
    found = cap_residual([Cap(noise * chance.standard_normal((15, 15)), noise) for _ in range(8)])
    assert found.value < 3 * found.sd
    assert 0 < found.sd < noise


def test_one_cap_and_caps_that_share_too_little_are_refused():
    seen = np.full((15, 15), np.nan)
    seen[0] = 0.0
    for caps in ([Cap(np.zeros((15, 15)), 0.0)], [Cap(seen, 0.0)] * 2):
        with pytest.raises(IllConditioned):
            cap_residual(caps)
