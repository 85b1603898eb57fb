"""Contacts made from heights: their content, and refused heights."""

import doctest

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import Contact, Pose, types

PIXEL = 1e-3
Y, X = np.mgrid[-40:41, -30:31] * PIXEL
CAP = np.maximum(6e-3 - (X**2 + Y**2) / 40e-3, 0.0)


def test_points_lie_on_the_pixels_of_the_membrane_frame():
    made = Contact.from_heights(CAP, PIXEL, noise=1e-4)
    assert made.surface.shape == (81, 61, 3)
    np.testing.assert_allclose(made.surface[..., 0], X, atol=1e-12)
    np.testing.assert_allclose(made.surface[..., 1], Y, atol=1e-12)
    np.testing.assert_array_equal(made.surface[..., 2], CAP)
    np.testing.assert_array_equal(made.points, made.surface[made.labels == 2])
    assert (made.rays == [0.0, 0.0, -1.0]).all()
    assert (made.noise, made.pose, made.hand_height, made.stretch) == (1e-4, Pose(), 0.0, None)


def test_what_is_not_seen_is_invalid():
    holed = CAP.copy()
    holed[:5] = np.nan
    made = Contact.from_heights(holed, PIXEL, noise=1e-4, pose=Pose((0.1, 0.0, 0.2)), stretch=0.01)
    assert (made.labels[:5] == 255).all()
    assert (made.confidence[:5] == 0).all()
    assert np.isnan(made.surface[:5]).all()
    assert (made.hand_height, made.stretch) == (0.2, 0.01)


def test_what_is_labelled_invalid_is_no_surface_of_the_contact():
    labels = np.where(X**2 + Y**2 < 0.01**2, 2, 1)
    labels[:10] = 255
    given = CAP.copy()
    made = Contact.from_heights(given, PIXEL, noise=1e-4, labels=labels)
    assert np.isnan(made.surface[:10]).all()
    assert np.isfinite(made.surface[10:]).all()
    np.testing.assert_array_equal(given, CAP)


@pytest.mark.parametrize("form", ["mask", "classes"])
def test_labels_may_be_given(form):
    touching = X**2 + Y**2 < 0.01**2
    labels = touching if form == "mask" else np.where(touching, 2, 0)
    made = Contact.from_heights(np.zeros_like(CAP), PIXEL, noise=1e-4, labels=labels)
    assert len(made.points) == touching.sum()
    assert (made.confidence == 1).all()


def test_pixels_labelled_invalid_are_as_if_not_seen():
    """A bump that the labels left out was measured all the same: the surface still held it."""
    y, x = np.mgrid[-80:81, -60:61] * 0.5e-3
    bumps = [np.maximum(6e-3 - (x**2 + (y - middle) ** 2) / 40e-3, 0.0) for middle in (-0.02, 0.02)]
    heights, left_out = sum(bumps), bumps[1] > 0
    given, labels = heights.copy(), np.where(bumps[0] > 3e-3, 2, np.where(left_out, 255, 0))
    made = Contact.from_heights(given, 0.5e-3, noise=1e-4, labels=labels)
    unseen = Contact.from_heights(np.where(left_out, np.nan, heights), 0.5e-3, noise=1e-4, labels=labels)
    for field in ("points", "rays", "labels", "surface", "confidence"):
        np.testing.assert_array_equal(getattr(made, field), getattr(unseen, field))
    assert np.isnan(made.surface[left_out]).all()
    np.testing.assert_array_equal(given, heights)


def test_the_examples_run():
    found = doctest.testmod(types)
    assert (found.failed, found.attempted > 0) == (0, True)


def test_a_stretch_is_checked_with_labels_as_without():
    for stretch in ("40 mm", 40.0, -0.01, np.nan):
        for labels in (None, CAP > 3e-3):
            with pytest.raises(InvalidInput, match="a stretch is from 0 to"):
                Contact.from_heights(CAP, PIXEL, noise=1e-4, labels=labels, stretch=stretch)


def test_text_with_a_unit_and_ragged_rows():
    heights = np.zeros((40, 40))
    heights[15:25, 15:25] = 2e-3
    one = Contact.from_heights(heights, "0.5 mm", noise="0.1 mm", labels=np.where(heights > 0, 2, 0))
    assert one.noise == 1e-4
    with pytest.raises(InvalidInput, match="heights are an array"):
        Contact.from_heights([[0.0, 0.1], [0.0]], 0.5e-3, noise=1e-4)
    with pytest.raises(InvalidInput, match="a depth image is an array"):
        DepthFrame.from_array([[0.1, 0.1], [0.1]], Intrinsics(60, 60, 20, 20, 40, 40), unit=1e-4)
    assert DepthFrame.from_array(np.full((40, 40), 0.1), Intrinsics(60, 60, 20, 20, 40, 40), unit="0.1 mm").unit == 1e-4
