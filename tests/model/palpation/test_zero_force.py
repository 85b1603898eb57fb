import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model import undeformed_height

DEPTHS = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])


@given(h0=st.floats(0.01, 0.2), c=st.floats(0, 5))
def test_noise_free_readings_give_the_exact_height(h0, c):
    found = undeformed_height(DEPTHS, h0 - c * DEPTHS**1.5, np.full(5, 1e-4))
    assert found.value == pytest.approx(h0, abs=1e-12)
