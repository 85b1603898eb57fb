import numpy as np
import pytest

from stretch_bt.perception.robust import scale_of


@pytest.mark.parametrize("outliers", [0.0, 0.3])
def test_scale_ignores_outliers(outliers):
    rng = np.random.default_rng(0)
    residuals = rng.normal(0.0, 2.0, 20000)
    hit = rng.random(20000) < outliers
    residuals[hit] = rng.uniform(30.0, 100.0, hit.sum())
    assert scale_of(residuals) == pytest.approx(2.0, rel=0.1)
