import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import hertz_force, object_modulus
from stretch_bt.units import Estimate


@given(
    modulus=st.floats(1e3, 1e7), membrane=st.floats(1e3, 1e5), radius=st.floats(0.005, 0.05), both=st.floats(1e-3, 0.02)
)
def test_it_inverts_the_papers_formula(modulus, membrane, radius, both):
    force = hertz_force("sphere", both, membrane, radius=radius, object_modulus=modulus)
    depth = (force * 0.75 / (4 / 3 * membrane * math.sqrt(radius))) ** (2 / 3)
    found = object_modulus(*(Estimate(v, 0.0) for v in (force, both - depth, depth, radius)))
    assert found.value == pytest.approx(modulus, rel=1e-6)
    assert found.sd == 0.0


def test_the_deviation_is_that_of_many_draws():
    given = [Estimate(1.2, 0.02), Estimate(0.002, 1e-4), Estimate(0.008, 1e-4), Estimate(0.03, 1e-3)]
    random = np.random.default_rng(3)
    draws = [[Estimate(random.normal(e.value, e.sd), 0.0) for e in given] for _ in range(4000)]
    found = object_modulus(*given)
    assert np.std([object_modulus(*d).value for d in draws]) == pytest.approx(found.sd, rel=0.05)


@pytest.mark.parametrize(
    ("place", "value", "error"),
    [
        (1, Estimate(1e-4, 1e-4), IllConditioned),
        (1, Estimate(-1e-4, 1e-6), IllConditioned),
        (0, Estimate(0.0, 0.0), IllConditioned),
        (3, Estimate(0.0, 0.0), InvalidInput),
        (3, Estimate(math.inf, 0.0), InvalidInput),
        (2, Estimate(math.nan, 0.0), InvalidInput),
    ],
)
def test_what_carries_no_answer_is_refused(place, value, error):
    given = [Estimate(1.2, 0.02), Estimate(0.002, 1e-4), Estimate(0.008, 1e-4), Estimate(0.03, 1e-3)]
    given[place] = value
    with pytest.raises(error):
        object_modulus(*given)
