import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import undeformed_height

DEPTHS = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])


@given(h0=st.floats(0.01, 0.2), c=st.floats(0, 5))
def test_noise_free_readings_give_the_exact_height(h0, c):
    found = undeformed_height(DEPTHS, h0 - c * DEPTHS**1.5, np.full(5, 1e-4))
    assert found.value == pytest.approx(h0, abs=1e-12)


@pytest.mark.parametrize(("c", "least", "most"), [(1.5, 0.85, 1.15), (0.0, 0.65, 1.0)])
def test_the_sd_is_honest(c, least, most):
    """The error over its sd has a spread of 1; where the object is rigid the stated sd is somewhat too large."""
    random = np.random.default_rng(2)
    sds = np.array([1e-4, 2e-4, 1e-4, 2e-4, 1e-4])
    ratios = []
    for _ in range(600):
        found = undeformed_height(DEPTHS, 0.06 - c * DEPTHS**1.5 + random.normal(0, sds), sds)
        ratios.append((found.value - 0.06) / found.sd)
    assert least < math.sqrt(np.mean(np.square(ratios))) < most


def test_heights_that_rise_with_depth_are_averaged():
    found = undeformed_height([1e-3, 5e-3], [0.06, 0.061], [1e-3, 1e-3])
    assert found.value == pytest.approx(0.0605)


@pytest.mark.parametrize(
    ("depths", "heights", "sds", "kind"),
    [
        ([1e-3], [0.06], [1e-4], IllConditioned),
        ([2e-3, 2e-3], [0.06, 0.06], [1e-4, 1e-4], IllConditioned),
        ([0.0, 0.0], [0.06, 0.06], [1e-4, 1e-4], IllConditioned),
        ([1e-3, 2e-3], [0.06], [1e-4, 1e-4], InvalidInput),
        ([1e-3, math.nan], [0.06, 0.06], [1e-4, 1e-4], InvalidInput),
        ([1e-3, -2e-3], [0.06, 0.06], [1e-4, 1e-4], InvalidInput),
        ([1e-3, 2e-3], [0.06, 0.06], [1e-4, 0.0], InvalidInput),
    ],
)
def test_readings_without_an_answer(depths, heights, sds, kind):
    with pytest.raises(kind):
        undeformed_height(depths, heights, sds)
