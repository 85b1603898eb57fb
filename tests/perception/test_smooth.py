import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.perception.smooth import derivative, enlarge, gain, gaussian, shrink, slope, smooth


@given(st.floats(1.0, 12.0), st.integers(0, 2), st.lists(st.floats(-2, 2), min_size=3, max_size=3))
def test_derivatives_are_exact_on_quadratics(sigma, order, coefficients):
    kernel = gaussian(sigma, order)
    u = np.arange(kernel.size) - kernel.size // 2
    a, b, c = coefficients
    expected = (a + c * float(gaussian(sigma, 0) @ u**2), b, 2 * c)[order]
    assert kernel @ (a + b * u + c * u**2) == pytest.approx(expected, abs=1e-8)


def test_derivatives_of_an_image_have_the_axes_of_the_image():
    v, u = np.mgrid[0:60, 0:80].astype(np.float32)
    image = 0.5 * u + 0.25 * v + 0.02 * u * v
    inner = np.s_[20:-20, 20:-20]
    np.testing.assert_allclose(derivative(image, 3.0, 1, 0)[inner], (0.5 + 0.02 * v)[inner], rtol=1e-4)
    np.testing.assert_allclose(derivative(image, 3.0, 0, 1)[inner], (0.25 + 0.02 * u)[inner], rtol=1e-4)
    np.testing.assert_allclose(derivative(image, 3.0, 1, 1)[inner], 0.02, rtol=1e-3)
    np.testing.assert_allclose(slope(image, 1)[inner], (0.5 + 0.02 * v)[inner], rtol=1e-4)
    np.testing.assert_allclose(slope(image, 0)[inner], (0.25 + 0.02 * u)[inner], rtol=1e-4)


def test_smoothing_ignores_what_invalid_pixels_hold():
    image = np.full((40, 50), 3.0, dtype=np.float32)
    valid = np.random.default_rng(0).random((40, 50)) < 0.7
    image[~valid] = 1e3
    mean, cover = smooth(image, valid.astype(np.float32), 3.0)
    np.testing.assert_allclose(mean, 3.0, rtol=1e-5)
    assert 0.5 < cover[20, 25] < 0.9


@pytest.mark.parametrize("step", [1, 2, 4])
def test_bins_hold_the_mean_of_what_is_valid_and_enlarging_goes_back(step):
    v, u = np.mgrid[0:43, 0:50].astype(np.float32)
    image = 0.5 * u - 0.25 * v
    valid = np.ones(image.shape, dtype=bool)
    valid[10, 10] = False
    garbage = np.where(valid, image, np.float32(1e3))
    mean, share = np.where(valid, garbage, np.float32(0)), valid.astype(np.float32)
    for _ in range(int(np.log2(step))):
        mean, share = shrink(mean, share)
    assert mean.shape == (-(-43 // step), -(-50 // step))
    at = 10 // step
    assert share[at, at] == pytest.approx(1 - 1 / step**2)
    inner = np.s_[20:36, 20:40]
    np.testing.assert_allclose(enlarge(mean, step, image.shape)[inner], image[inner], atol=1e-4)
    if step > 1:
        block = np.s_[at * step : (at + 1) * step, at * step : (at + 1) * step]
        assert mean[at, at] == pytest.approx(image[block][valid[block]].mean(), rel=1e-5)


@pytest.mark.parametrize("orders", [[(0, 0, 1.0)], [(2, 0, 1.0)], [(2, 0, 1.0), (0, 2, 1.0)]])
def test_gain_is_the_noise_that_comes_out(orders):
    noise = np.random.default_rng(1).normal(size=(300, 300)).astype(np.float32)
    out = sum(weight * derivative(noise, 2.5, a, b) for a, b, weight in orders)[10:-10, 10:-10]
    assert out.std() == pytest.approx(gain(2.5, *orders), rel=0.05)
