"""Noise measured on made images of known noise, and on the real recordings against what is known of them."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.frames import Intrinsics
from stretch_bt.perception import frame_noise, load_depth_png, load_depth_stack, pixel_noise
from stretch_bt.perception.correlation import noise_of
from stretch_bt.perception.smooth import derivative

SR305 = Intrinsics(476.007, 476.007, 313.683, 242.755, 640, 480)


def curved(shape):
    v, u = np.mgrid[0 : shape[0], 0 : shape[1]]
    return 0.2 + 1e-4 * u - 2e-4 * v + 3e-7 * u * u - 2e-7 * u * v


def test_white_noise_on_a_curved_surface_is_measured():
    rng = np.random.default_rng(0)
    found = pixel_noise(curved((150, 200)) + rng.normal(0, 0.3e-3, (150, 200)))
    assert np.sqrt((found.sd**2).mean()) == pytest.approx(0.3e-3, rel=0.02)
    assert found.sd.shape == found.depth.shape == (10 * 13,)
    assert np.abs(found.correlation).max() < 0.05


def test_correlated_noise_shows_its_length():
    rng = np.random.default_rng(0)
    noise = gaussian_filter(rng.standard_normal((300, 300)), 1.0) * 2 * np.sqrt(np.pi) * 0.3e-3
    found = pixel_noise(curved((300, 300)) + noise, width=50)
    np.testing.assert_allclose(found.correlation, np.exp(-np.array([1, 4, 9]) / 4), atol=0.05)
    assert np.sqrt((found.sd**2).mean()) == pytest.approx(0.3e-3, rel=0.1)


def test_noise_from_frame_to_frame_is_measured_with_its_memory():
    rng = np.random.default_rng(0)
    state, frames = rng.normal(0, 0.2e-3, (60, 80)), []
    for _ in range(60):
        frames.append(curved((60, 80)) + state)
        state = 0.6 * state + 0.8 * rng.normal(0, 0.2e-3, (60, 80))
    frames[3][5, 5] = 0.0
    found = frame_noise(frames, lags=3)
    assert np.isnan(found.sd[5, 5])
    assert np.nanmedian(found.sd) == pytest.approx(0.2e-3, rel=0.05)
    np.testing.assert_allclose(found.correlation, [0.6, 0.36, 0.216], atol=0.05)


@pytest.mark.parametrize(("length", "sd"), [(0.0, 0.3), (1.0, 0.5), (2.0, 1.0)])
def test_what_means_leave_of_an_image_shows_the_noise_and_its_length(length, sd):
    noise = np.random.default_rng(0).standard_normal((300, 300))
    if length:
        noise = gaussian_filter(noise, length) * 2 * np.sqrt(np.pi) * length
    rest = (sd * noise).astype(np.float32)
    for _ in range(2):
        rest = rest - derivative(rest, 4.0, 0, 0)
    found, over = noise_of(rest, np.ones(rest.shape, dtype=bool), 4.0)
    assert found == pytest.approx(sd, rel=0.08)
    assert over == pytest.approx(length, abs=0.3 if length == 0.0 else 0.1)


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda: pixel_noise(np.zeros((40, 40))), IllConditioned, "valid throughout"),
        (lambda: pixel_noise(np.full((40, 40), 0.2), width=4), InvalidInput, "at least 5"),
        (lambda: pixel_noise(np.full((40, 40), 200.0)), InvalidInput, "another unit"),
        (lambda: frame_noise([np.full((4, 4), 0.2)] * 3), InvalidInput, "at least 7"),
        (lambda: frame_noise([np.zeros((4, 4))] * 9), IllConditioned, "in all frames"),
        (lambda: frame_noise([np.full((4, 4), 0.2)] * 8 + [np.full((4, 5), 0.2)]), InvalidInput, "one shape"),
    ],
)
def test_what_carries_no_noise_figure_is_refused(call, error, said):
    with pytest.raises(error, match=said):
        call()


def test_the_noise_of_a_real_structured_light_camera(data):
    sd, depth, correlation = [], [], []
    for path in sorted((data / "sr305").glob("*.png")):
        found = pixel_noise(load_depth_png(path, unit=0.125e-3, intrinsics=SR305))
        sd.append(found.sd)
        depth.append(found.depth)
        correlation.append(found.correlation)
    np.testing.assert_allclose(np.mean(correlation, axis=0), [0.74, 0.45, 0.16], atol=0.1)
    sd, depth = np.concatenate(sd), np.concatenate(depth)
    for low, high in ((0.45, 0.6), (0.6, 0.7), (0.7, 0.8), (0.8, 1.0)):
        near = (depth > low) & (depth < high)
        quiet = np.quantile(sd[near], 0.1)
        assert quiet * 1e3 == pytest.approx(2.6e-7 * (1e3 * np.median(depth[near])) ** 2, rel=0.15)


def test_the_noise_of_a_real_membrane_at_rest_under_load(data):
    path = data / "membrane_press" / "punyo_press_z.npz"
    with np.load(path) as file:
        count = len(file["t"])
    lens = Intrinsics(600.0, 600.0, 235.0, 185.0, 470, 370)
    frames = list(load_depth_stack(path, unit=1e-4, intrinsics=lens, key="z_0p1mm", times=range(count)))[34:60]
    found = frame_noise(frames)
    assert 0.04e-3 < np.nanmedian(found.sd) < 0.05e-3
    np.testing.assert_allclose(found.correlation[[0, 1, 4]], [0.62, 0.39, 0.07], atol=0.1)
    top = np.s_[223:236, 164:177]  # where it is pressed highest
    assert np.std([frame.depth[top].mean() for frame in frames[6:25]], ddof=1) < 0.018e-3
