"""The outline of any form, where it begins: as a circle, which lies along no axis."""

import numpy as np
import pytest

from stretch_bt.perception.size.free_form import RATIO, FreeForm
from stretch_bt.perception.size.hypothesis import Context
from stretch_bt.perception.size.measure import FILLET, FILLET_SD
from stretch_bt.perception.size.prior import shipped_prior
from stretch_bt.perception.size.start import Start


@pytest.fixture(params=[None, 0.04])
def shape(request):
    return FreeForm(Context(request.param, FILLET, FILLET_SD, shipped_prior()))


def started(shape, wide=0.012):
    start = Start(0.001, -0.002, 0.008, wide, wide, wide, wide, 0.0)
    return shape.starts(start)[0]


@pytest.mark.parametrize("wide", [0.006, 0.012])
def test_the_last_digit_of_a_circle_changes_neither_its_prior_nor_the_slopes(shape, wide):
    """Rounding once set which way it lay, and slopes grew a hundredfold: the same frame gave 1 % more or less on another processor, or no size."""
    q = started(shape, wide)
    against, slopes = shape.prior(q)
    for digit in (1e-15, -1e-15, 3e-15):
        other = q * (1.0 + digit * np.arange(q.size))
        found, by = shape.prior(other)
        assert found == pytest.approx(against, rel=1e-9, abs=1e-9)
        assert by == pytest.approx(slopes, rel=1e-4, abs=1e-4 * np.abs(slopes).max())


def test_slopes_of_the_prior_are_those_of_its_values(shape):
    q = started(shape)
    q[3:11] += 1e-4 * np.array([3.0, -2.0, 1.0, 2.0, -1.0, 1.0, 2.0, -2.0])
    _, slopes = shape.prior(q)
    for n in (2, 3, 4, RATIO):
        step = 1e-5 if n != RATIO else 1e-4
        up, down = (shape.prior(q + sign * step * np.eye(q.size)[n])[0] for sign in (1.0, -1.0))
        assert slopes[n] == pytest.approx((up - down) / (2.0 * step), rel=0.05, abs=0.02 * np.abs(slopes[n]).max())
