"""The height of a top over the table, also of one that shows no contact."""

import numpy as np
import pytest

from stretch_bt.behaviors._top_height import height_over_table
from stretch_bt.errors import IllConditioned, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.hardware.hand import HandGeometry
from stretch_bt.perception import find_contact

CAMERA = Intrinsics(400.0, 400.0, 99.5, 109.5, 200, 220)
DISTANCE = 0.2
HAND = HandGeometry()


def frame(heights, noise, stretch=0.03):
    """Return what a camera sees of heights (h, w), m, over the flat membrane."""
    depth = DISTANCE - heights + np.random.default_rng(0).normal(0.0, noise, (220, 200))
    return DepthFrame.from_array(depth, CAMERA, unit=8e-6, plane_distance=DISTANCE, stretch=stretch)


def hill(top):
    """Return heights (h, w), m, of a hill from clamp to clamp, so little curved that no pixel is taken for contact."""
    along = (np.arange(220) - CAMERA.cy) * DISTANCE / CAMERA.fy
    return np.repeat(top * np.cos(np.pi * along / 0.11).clip(0.0)[:, None], 200, axis=1)


@pytest.mark.parametrize("heights", [0.03, 0.06, 0.02 + 0.00025 * (np.arange(200) - 100.0)])
def test_what_is_no_membrane_has_no_height(heights):
    with pytest.raises(IllConditioned, match="no membrane"):
        height_over_table(frame(heights * np.ones((220, 200)), 1e-4), HAND, None)


@pytest.mark.parametrize("noise", [5e-5, 3e-4, 1e-3])
def test_a_top_without_contact_is_as_uncertain_as_a_pixel_of_its_frame(noise):
    shot = frame(hill(0.005), noise)
    with pytest.raises(NoContact):
        find_contact(shot)
    top = height_over_table(shot, HAND, None)
    assert abs(top - 0.005) < top.sd
    assert max(0.3e-3, 0.95 * noise) < top.sd < 0.65e-3 + 1.1 * noise


def test_a_top_without_contact_is_within_the_reach_of_the_membrane():
    with pytest.raises(IllConditioned, match=r"at most 0\.005 m"):
        height_over_table(frame(hill(0.01), 1e-4, stretch=0.0), HandGeometry(gauge=0.01), None)
