"""Guards of the sheet solver: no step through a thin body, and no answer where only rounding is left or a body has sunk in."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.simulation.membrane.sheet.newton import _rounded
from stretch_bt.simulation.membrane.sheet.problem import Evaluation


@given(left=st.one_of(st.just(0.0), st.floats(1e-6, 2.0)), gain=st.sampled_from([0.0, 1e-14, 1e-6]))
def test_a_state_is_rounded_only_in_balance(left, gain):
    gradient = np.zeros((3, 1, 3))
    gradient[1, 0, 2] = left
    here = Evaluation(1.0, gradient, np.array([[0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]]), np.zeros(3))
    direction = np.array([[[0.0, 0.0, -gain / left if left else 0.0]]])
    assert _rounded(here, direction) == (left <= 1e-3 and gain * (left > 0) < 1e-12)
