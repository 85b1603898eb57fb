import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.perception.robust import scale_of
from stretch_bt.perception.shapes.inliers import Inliers
from stretch_bt.perception.shapes.inliers_kernel import bulk, half_of, normal_step, ranked


@settings(max_examples=60)
@given(seed=st.integers(0, 2**31), size=st.integers(1, 200), ties=st.booleans())
def test_ranks_bulk_and_densest_half_are_those_of_sorted_values(seed, size, ties):
    values = np.random.default_rng(seed).standard_cauchy(size)
    values = np.round(values) if ties else values
    assert ranked(values.copy(), size // 3) == np.sort(values)[size // 3]
    assert bulk(values, 1) == pytest.approx(scale_of(values, 1), rel=1e-12)
    rank, half = np.sort(values), size // 2
    widths = rank[half:] - rank[: size - half]
    assert half_of(values)[1] == pytest.approx(1.4826 * widths.min() / 2.0, rel=1e-9, abs=1e-15)


def test_a_step_is_weighted_least_squares_and_one_that_is_free_is_told():
    rng = np.random.default_rng(0)
    jacobian, weights, residuals = rng.normal(size=(6, 50)), rng.uniform(0.0, 1.0, 50), rng.normal(size=50)
    step = np.empty(6)
    assert normal_step(jacobian, weights, residuals, step)
    weighted = jacobian * weights
    np.testing.assert_allclose(step, np.linalg.solve(weighted @ jacobian.T, weighted @ residuals), rtol=1e-9)
    jacobian[4] = 2.0 * jacobian[1] - jacobian[3]
    assert not normal_step(jacobian, weights, residuals, step)


def test_the_mixture_finds_noise_and_outliers_on_either_side():
    rng = np.random.default_rng(1)
    noise = rng.normal(0.0, 0.5, 4000)
    residuals = np.concatenate([noise, rng.uniform(0.0, 20.0, 1000)])
    mixture = Inliers.first(residuals, 4, 1e-9)
    for _ in range(20):
        mixture = mixture.next(residuals, mixture.weights(residuals), 4, 1e-9)
    assert mixture.scale == pytest.approx(0.5, rel=0.05)
    assert mixture.above == pytest.approx(1000 / 20.0 / 4000, rel=0.25)
    assert mixture.below < 0.3 * mixture.above
    weights = mixture.weights(residuals)
    assert weights[:4000].mean() > 0.95
    assert weights[4000:].mean() < 0.15
    assert (np.diff(mixture.weights(np.linspace(0.0, 30.0, 50))) <= 0.0).all()
