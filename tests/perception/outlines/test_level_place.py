"""What noise and blur do to the place of a level line."""

import numpy as np
import pytest

from stretch_bt.perception import outline_at
from stretch_bt.perception.types import SurfaceNoise

PITCH = 0.4e-3


def cone_with_flat_top(noise, kernel, seed, reach=0.012, steep=0.3):
    import cv2

    v, u = np.mgrid[:160, :160]
    x, y = (u - 80) * PITCH, (v - 80) * PITCH
    heights = np.maximum(0.012 - steep * np.maximum(np.hypot(x, y) - reach, 0.0), 0.0)
    error = np.random.default_rng(seed).standard_normal(x.shape)
    if kernel:
        error = 2 * np.sqrt(np.pi) * kernel * cv2.GaussianBlur(error, (0, 0), kernel)
    return np.stack([x, y, heights + noise * error], axis=2)


@pytest.mark.parametrize(("noise", "kernel"), [(0.3e-3, 0.0), (0.2e-3, 3.0)])
def test_area_and_perimeter_of_a_level_are_as_sure_as_stated(noise, kernel):
    """With the roughness alone the error of the area was 4 to 12 times what was stated."""
    true, of = 0.012 + 0.0015 / 0.3, SurfaceNoise(noise, max(4 * np.pi * kernel**2, 1.0))
    found = [outline_at(cone_with_flat_top(noise, kernel, seed), 0.0015, noise=of) for seed in range(12)]
    area = [(f.area - np.pi * true**2) / f.area_sd for f in found]
    perimeter = [(f.perimeter - 2 * np.pi * true) / f.perimeter_sd for f in found]
    assert 0.3 < np.sqrt(np.mean(np.square(area))) < 1.5
    assert 0.3 < np.sqrt(np.mean(np.square(perimeter))) < 1.5


def test_a_flat_skirt_and_noise_state_the_place_wider():
    steep, flat = (
        outline_at(cone_with_flat_top(0.1e-3, 3.0, 1, steep=s), 0.0015, noise=SurfaceNoise(0.1e-3, 113.0)).place_sd
        for s in (0.4, 0.15)
    )
    assert flat > 1.8 * steep
    assert outline_at(cone_with_flat_top(0.0, 0.0, 1), 0.0015).place_sd < 0.2e-3
