"""The derivatives with which a bend is fitted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.perception.solids.bend import _linear, _slopes
from stretch_bt.perception.solids.profile import HeightProfile

STEP = 1e-7  # m


@pytest.mark.parametrize("curved", [False, True])
@given(st.integers(0, 2**31), st.floats(-3e-3, 3e-3), st.floats(0.3e-3, 5e-3))
def test_slopes_are_those_of_the_residuals_with_the_other_numbers_fitted(curved, seed, place, length):
    rng = np.random.default_rng(seed)
    at = np.sort(rng.uniform(-12e-3, 12e-3, 60))
    bent = np.maximum(at - 1e-3, 0.0) * rng.uniform(-1.0, 1.0) + rng.normal(0.0, 1e-4, at.shape)
    profile = HeightProfile(at, bent, rng.integers(1, 30, at.shape).astype(float), 2e-5)

    def left(moved, longer):
        return _linear(profile, place + moved, length + longer, curved)[1]

    found = _slopes(profile, place, length, curved)
    for column, (moved, longer) in zip(found.T, ((STEP, 0.0), (0.0, STEP)), strict=True):
        slope = (left(moved, longer) - left(-moved, -longer)) / (2 * STEP)
        assert column == pytest.approx(slope, abs=1e-4 * max(np.abs(found).max(), 1e-3))
