"""The width of what is labelled as contact."""

import numpy as np
import pytest

from stretch_bt.perception import contact_width

PITCH = 0.4e-3
Y, X = np.meshgrid(PITCH * np.arange(-100, 101), PITCH * np.arange(-80, 81), indexing="ij")
POINTS = np.stack([X, Y, np.full(X.shape, 5e-3)], axis=-1)


def labelled(inside):
    return np.where(inside, 2, 1).astype(np.uint8)


@pytest.mark.parametrize("a", [4e-3, 8e-3, 12e-3])
@pytest.mark.parametrize("b", [6e-3, 15e-3])
@pytest.mark.parametrize("at", [(0.0, 0.0), (5e-3, -7e-3)])
def test_an_ellipse_is_as_wide_as_its_axes(a, b, at):
    found = contact_width(POINTS, labelled(np.hypot((X - at[0]) / a, (Y - at[1]) / b) < 1))
    # a chord that passes the middle at 0.75 mm is shorter by its own part
    for value, sd, wide, across in ((found.i, found.i_sd, 2 * a, b), (found.j, found.j_sd, 2 * b, a)):
        shortened = wide * (1 - np.sqrt(1 - (1.5e-3 / across) ** 2))
        assert -shortened - 3 * PITCH < value - wide < 1.5 * PITCH
        assert PITCH / 3 < sd < 1e-3


def test_holes_and_invalid_pixels_do_not_make_it_narrower():
    inside = np.hypot(X, Y) < 10e-3
    holed = inside & ~(np.hypot(X, Y) < 6e-3)
    points = POINTS.copy()
    points[::7, ::5] = np.nan
    assert contact_width(points, labelled(holed)).i == pytest.approx(
        contact_width(POINTS, labelled(inside)).i, abs=4 * PITCH
    )
