import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception.size.correlation import correlation_area

ROUND = np.hypot(*np.mgrid[-35:36, -35:36]) < 33


@pytest.mark.parametrize("kernel", [0.0, 0.7, 1.0, 1.5])
def test_smoothed_noise_has_the_area_of_its_kernel(kernel):
    rng = np.random.default_rng(4)
    found = []
    for _ in range(20):
        noise = rng.standard_normal(ROUND.shape)
        found.append(correlation_area(gaussian_filter(noise, kernel) if kernel else noise, ROUND))
    # the sum of the autocorrelation of a Gaussian kernel of that sd
    assert np.mean(found) == pytest.approx(max(4 * np.pi * kernel**2, 1.0), rel=0.2)


def test_nothing_left_over_is_no_correlation():
    assert correlation_area(np.zeros(ROUND.shape), ROUND) == 1.0
