import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from stretch_bt.hardcases.strategies.balloons import STEPS
from stretch_bt.simulation.balloons.curve import PowerCurve


@given(steps=STEPS, at=st.floats(1e-6, 1e4))
def test_it_rises_where_the_points_rise_and_tells_its_slope(steps, at):
    x, y = np.cumprod([s[0] for s in steps]), np.cumprod([s[1] for s in steps])
    curve = PowerCurve(x, y)
    assert_allclose([curve(float(a))[0] for a in x], y, rtol=1e-9)
    step = 1e-6 * at
    (low, _), (value, slope), (high, _) = curve(at - step), curve(at), curve(at + step)
    assert low <= value * (1 + 1e-12)
    assert slope >= 0
    assert (high - low) / (2 * step) == pytest.approx(slope, rel=1e-3, abs=1e-6 * value / at)
