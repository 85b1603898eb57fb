import numpy as np
import pytest

from stretch_bt.perception.robust import scale_of, tukey_psi_slope, tukey_weights


@pytest.mark.parametrize("outliers", [0.0, 0.3])
def test_scale_ignores_outliers(outliers):
    rng = np.random.default_rng(0)
    residuals = rng.normal(0.0, 2.0, 20000)
    hit = rng.random(20000) < outliers
    residuals[hit] = rng.uniform(30.0, 100.0, hit.sum())
    assert scale_of(residuals) == pytest.approx(2.0, rel=0.1)


def test_the_slope_is_the_derivative_of_the_weighted_residual():
    u = np.linspace(-1.5, 1.5, 301)
    numeric = (((u + 1e-6) * tukey_weights(u + 1e-6)) - ((u - 1e-6) * tukey_weights(u - 1e-6))) / 2e-6
    np.testing.assert_allclose(tukey_psi_slope(u), numeric, atol=1e-5)
