"""Quantities that are 0 or come from a known distribution."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.perception.perhaps import either, odds_about, perhaps_above
from stretch_bt.units import Estimate

VALUES = st.floats(-2e-3, 2e-3), st.floats(1e-7, 1e-3), st.floats(1e-6, 5e-3)


@given(*VALUES)
def test_what_is_never_below_0_comes_out_so(seen, sd, most):
    found = perhaps_above(Estimate(seen, sd), most)
    assert 0.0 <= found.value <= most
    assert 0.0 <= found.sd <= most


@pytest.mark.parametrize("share", [0.2, 0.5])
@pytest.mark.parametrize("sd", [0.03, 0.3, 3.0])
def test_what_is_drawn_so_is_found_with_its_error(sd, share):
    draws = np.random.default_rng(3)
    there, noise, about = draws.random(4000) < share, draws.normal(0, sd, 4000), Estimate(1.0, 0.4)
    errors = []
    for value, off in zip(np.where(there, draws.normal(about.value, about.sd, 4000), 0.0), noise, strict=True):
        odds = share / (1.0 - share) * odds_about(Estimate(value + off, sd), about)
        total = sd**2 + about.sd**2
        mean = ((value + off) * about.sd**2 + about.value * sd**2) / total
        found = either(odds, Estimate(mean, sd * about.sd / np.sqrt(total)), Estimate(0.0, 0.0))
        errors.append((found.value - value, found.sd))
    _as_stated(errors)


@pytest.mark.parametrize(
    ("seen", "most"), [(-3, 4), (0, 4), (2, 4), (5, 4), (1, 0.01), (-10, 0.1), (-29, 3), (25, 30), (34, 4)]
)
def test_what_is_0_or_above_has_the_mean_and_the_deviation_of_its_posterior(seen, most):
    x = np.linspace(0, most, 400_001)
    dense = np.exp(seen * x - x * x / 2) / most  # over the likelihood of 0
    one, mean, square = (np.trapezoid(dense * x**k, x) for k in range(3))
    found = perhaps_above(Estimate(seen, 1.0), most)
    assert found.value == pytest.approx(mean / (1 + one), rel=1e-4)
    assert found.sd**2 == pytest.approx(square / (1 + one) - (mean / (1 + one)) ** 2, rel=1e-3)


def _as_stated(errors):
    off, stated = np.array(errors).T
    assert np.sqrt(np.mean(off**2)) == pytest.approx(np.sqrt(np.mean(stated**2)), rel=0.05)
