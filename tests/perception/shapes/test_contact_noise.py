import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception.shapes.contact_noise import NoiseParts, noise_left


def power(noise):
    """Return the variance of a mean over many pixels, times their number."""
    return noise.white + sum(4 * np.pi * length**2 * variance for variance, length in noise.smooth)


@pytest.mark.parametrize(
    ("white", "smooth", "length"), [(1.0, 0.0, 1.0), (0.5, 0.5, 2.5), (0.1, 1.0, 3.0), (0.1, 1.0, 1.1)]
)
def test_white_and_smooth_parts_are_told_apart(white, smooth, length):
    true = NoiseParts(white**2, ((smooth**2, length),) if smooth else ())
    for seed in range(2):
        rng = np.random.default_rng(seed)
        blurred = 2 * np.sqrt(np.pi) * length * gaussian_filter(rng.standard_normal((160, 160)), length)
        residuals = white * rng.standard_normal((160, 160)) + smooth * blurred
        residuals[rng.random(residuals.shape) < 0.02] = np.nan
        residuals[rng.random(residuals.shape) < 0.002] = 20.0  # flying pixels
        found = noise_left(residuals, 1e-12)
        assert found.variance == pytest.approx(true.variance, rel=0.15)
        assert power(found) == pytest.approx(power(true), rel=0.35)


def test_no_noise_leaves_the_floor():
    assert noise_left(np.zeros((30, 30)), 1e-12) == NoiseParts(1e-12)
