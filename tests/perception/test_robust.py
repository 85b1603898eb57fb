import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.perception.robust import quantile, scale_of

DRAWS = {
    "normal": lambda rng, n: rng.normal(size=n),
    "counts": lambda rng, n: np.round(rng.normal(size=n)),
    "wild": lambda rng, n: np.exp(rng.normal(0.0, 60.0, n)),
    "alike": lambda rng, n: np.full(n, rng.normal()),
    "tiny": lambda rng, n: rng.normal(size=n) * 1e-310,
    "beyond all range": lambda rng, n: rng.normal(size=n) * 1e308,
}


@given(
    st.sampled_from(sorted(DRAWS)),
    st.integers(1, 3000),
    st.sampled_from([np.float64, np.float32]),
    st.floats(0.0, 1.0),
    st.integers(0, 2**32 - 1),
)
def test_a_quantile_is_the_value_of_its_rank(kind, size, dtype, share, seed):
    rng = np.random.default_rng(seed)
    with np.errstate(over="ignore", invalid="ignore"):
        values = DRAWS[kind](rng, size).astype(dtype)
    before = values.copy()
    assert quantile(values, share) == np.sort(values)[min(int(share * size), size - 1)]
    np.testing.assert_array_equal(values, before)


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_rank_as_they_are_sorted(odd):
    values = np.array([3.0, odd, 1.0, 2.0, 5.0])
    for share in (0.0, 0.3, 0.5, 0.9):
        np.testing.assert_equal(quantile(values, share), np.sort(values)[int(share * 5)])


def test_values_that_nothing_may_change_and_integers_rank_likewise():
    values = np.arange(100.0)[::-1]
    values.flags.writeable = False
    assert quantile(values) == quantile(np.arange(100)) == 50.0


@pytest.mark.parametrize("outliers", [0.0, 0.3])
def test_scale_ignores_outliers(outliers):
    rng = np.random.default_rng(0)
    residuals = rng.normal(0.0, 2.0, 20000)
    hit = rng.random(20000) < outliers
    residuals[hit] = rng.uniform(30.0, 100.0, hit.sum())
    assert scale_of(residuals) == pytest.approx(2.0, rel=0.1)
