"""Other outlines than the one that is chosen, which fit as well."""

import numpy as np
import pytest
from height_noise import FILLET, LONG, NOISES, PITCH, WIDE, Surface, camera_of, relaxed, rounded, seen, viewed

from stretch_bt.perception import find_contact, measure_contact


@pytest.mark.parametrize("seed", [0, 3])
def test_an_oval_that_smooth_noise_makes_a_circle_states_how_narrow_it_may_be(seed):
    """It was called a circle 18 mm wide, 3.3 stated deviations too wide."""
    x, y = np.arange(-WIDE, WIDE + PITCH / 2, PITCH), np.arange(-LONG, LONG + PITCH / 2, PITCH)
    long, short = 18.75e-3, 9.54e-3
    past = (np.hypot(2 * x[None, :] / long, 2 * y[:, None] / short) - 1) * short / 2 + FILLET
    camera = camera_of(0.6e-3)
    surface = Surface(viewed(x, y, relaxed(4.4e-3 + rounded(past), 18.7), camera), 4.4e-3, camera)
    contact = find_contact(seen(surface, NOISES["shared 0.3, 3 px"], np.random.default_rng(seed)))
    size = measure_contact(contact.surface, contact.labels)
    assert abs(size.diameter_i - long) < 2 * size.diameter_i_sd
    assert abs(size.diameter_j - short) < 2 * size.diameter_j_sd < 16e-3
