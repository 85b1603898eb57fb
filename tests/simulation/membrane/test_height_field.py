import math

import numpy as np
import pytest

from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.height_field import HeightField


def field(surface, count=69, pitch=0.25e-3):
    """Return the height field of a function of x and y, m, over a square around the origin."""
    x = (np.arange(count) - (count - 1) / 2) * pitch
    return HeightField(surface(*np.meshgrid(x, x)), pitch)


def ball(x, y, radius=0.01, rim=0.9):
    """Return the height of a sphere that goes on along its flanks outside `rim` radii."""
    away, edge = np.hypot(x, y), rim * radius
    steep = rim / math.sqrt(1 - rim**2)
    inside = np.sqrt(np.maximum(radius**2 - away**2, 0.0))
    return np.where(away < edge, inside, radius * math.sqrt(1 - rim**2) - steep * (away - edge))


BALL = field(ball)


def test_equal_fields_are_equal_and_start_each_other():
    again = field(ball)
    assert again == BALL
    assert hash(again) == hash(BALL)
    assert field(ball, 67) != BALL
    assert BALL != "a ball"
    first = press(BALL, 0.03, 0.006)
    warm = press(again, 0.03, 0.007, start=first)
    assert warm.detail.shape.mesh is first.detail.shape.mesh
    with pytest.raises(ValueError, match="read-only"):
        BALL.heights[0, 0] = 1.0
