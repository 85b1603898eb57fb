import numpy as np
import pytest

from stretch_bt.model.carried import carried
from stretch_bt.units import Estimate


def test_a_deviation_is_that_of_draws() -> None:
    rng = np.random.default_rng(0)
    a, b = Estimate(2.0, 0.02), Estimate(-3.0, 0.05)
    found = carried(lambda x, y: x**3 / y, a, b)
    drawn = rng.normal(a.value, a.sd, 20000) ** 3 / rng.normal(b.value, b.sd, 20000)
    assert found.value == pytest.approx(-8 / 3)
    assert found.sd == pytest.approx(np.std(drawn), rel=0.03)


def test_what_is_exact_carries_nothing() -> None:
    assert carried(lambda x, y: x * y, Estimate(0.0, 0.0), Estimate(5.0, 0.0)).sd == 0.0
