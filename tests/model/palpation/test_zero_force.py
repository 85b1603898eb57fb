import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import POWER, drop_power, undeformed_height
from stretch_bt.units import Estimate

DEPTHS = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])


@given(h0=st.floats(0.01, 0.2), c=st.floats(0, 5))
def test_noise_free_readings_give_the_exact_height(h0, c):
    found = undeformed_height(DEPTHS, h0 - c * DEPTHS**1.5, np.full(5, 1e-4))
    assert found.value == pytest.approx(h0, abs=1e-12)


@given(h0=st.floats(0.01, 0.2), c=st.floats(0, 0.3), power=st.floats(0.6, 2.5))
def test_they_do_so_at_any_power(h0, c, power):
    heights = h0 - c * 1e-3 * (DEPTHS / 1e-3) ** power
    found = undeformed_height(DEPTHS, heights, np.full(5, 1e-6), power=Estimate(power, 0.2))
    assert found.value == pytest.approx(h0, abs=1e-9)
    other = undeformed_height(DEPTHS, heights, np.full(5, 1e-6), power=Estimate(power + 0.2, 0.2))
    assert abs(other.value - h0) <= 1.5 * other.sd


def test_a_tense_membrane_lets_the_drop_grow_less_with_depth():
    powers = [drop_power(Estimate(strain, 0.0), POWER).value for strain in (0.0, 0.05, 0.1, 0.4, 0.8, 2.0)]
    assert powers == sorted(powers, reverse=True)
    assert powers[0] * POWER.value == pytest.approx(3.1)
    assert powers[-1] * POWER.value == pytest.approx(1.29)


@pytest.mark.parametrize(
    "numbers", [(0.1, 0.0, 0.0, 0.3), (0.1, 0.0, -1.0, 0.3), (math.nan, 0.0, 1.3, 0.3), (0.1, 0.0, 1.3, math.inf)]
)
def test_a_power_needs_numbers(numbers):
    with pytest.raises(InvalidInput, match="must be finite"):
        drop_power(Estimate(*numbers[:2]), Estimate(*numbers[2:]))


@pytest.mark.parametrize("sds", [[1e-12, 1e3, 1e3, 1e3, 1e3], [1e-5, 1e20, 1e20, 1e20, 1e20]])
def test_readings_of_which_one_alone_counts_tell_no_height(sds):
    with pytest.raises(IllConditioned, match="depths further apart"):
        undeformed_height(DEPTHS, np.full(5, 0.06), sds)
