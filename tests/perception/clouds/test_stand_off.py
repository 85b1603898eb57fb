"""By how much points may stand off an object: beyond an edge by as much as they lie outside, on top and on a dome by no more than heights share."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from stretch_bt.perception.clouds.cloud import cloud_of
from stretch_bt.perception.clouds.relief import CELL, add_view
from stretch_bt.perception.clouds.seen import CellView
from stretch_bt.perception.clouds.stand_off import HANG_SD, stand_off, with_stand_off
from stretch_bt.perception.clouds.told import told_points

MM = 1e-3
HALF, TOP = 15 * MM, 30 * MM


def over(membrane):
    """Return the map of one press whose membrane has heights (n,), m, at x and y (n,), m, all of which touch within 18 mm."""
    cells = np.stack(np.meshgrid(np.arange(-40, 40), np.arange(-40, 40), indexing="ij"), axis=2).reshape(-1, 2)
    x, y = ((cells + 0.5) * CELL).T
    touched = np.maximum(np.abs(x), np.abs(y)) < 18 * MM
    return add_view(CellView(cells, membrane(x, y), touched, np.zeros(len(cells), dtype=bool)))


def edges(slope, width, turn=0.0):
    """Return a membrane that passes over the edges of a square top, each in a bend some cells wide."""

    def membrane(x, y):
        u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        below = slope * np.maximum(np.maximum(np.abs(u), np.abs(v)) - HALF, 0.0)
        return TOP - gaussian_filter(below.reshape(80, 80), width).ravel()

    return membrane


def beside(away, turn=0.0):
    """Return points, m, that lie given distances, m, outside a side of the top."""
    along = HALF + np.asarray(away)
    return np.column_stack([along * np.cos(turn), along * np.sin(turn), np.full(len(along), TOP)])


@pytest.mark.parametrize(("slope", "width"), [(0.15, 3.0), (0.3, 1.5), (0.6, 1.0)])
@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_beyond_an_edge_the_membrane_stands_off_by_about_as_much_as_it_lies_outside(slope, width, turn):
    away = np.array([0.8, 1.5, 2.2]) * MM
    found = stand_off(beside(away, turn), over(edges(slope, width, turn)))
    assert (found > 0.6 * away).all()
    assert (found < 2.0 * away).all()
    assert (np.diff(found) > 0).all()


@pytest.mark.parametrize("slope", [0.15, 0.6])
def test_on_the_top_it_does_not(slope):
    points = beside(np.array([-3.0, -6.0, -15.0]) * MM)
    relief = over(edges(slope, 1.5))
    assert (stand_off(points, relief) < 0.05 * MM).all()
    assert with_stand_off(cloud_of(points, 1e-5), relief).sd == pytest.approx(np.hypot(HANG_SD, 0.1 * MM), rel=0.05)


@pytest.mark.parametrize("radius", [20 * MM, 40 * MM])
def test_on_a_dome_it_does_not(radius):
    relief = over(lambda x, y: TOP - radius + np.sqrt(np.maximum(radius**2 - x**2 - y**2, (0.6 * radius) ** 2)))
    x = np.linspace(0.0, 0.4 * radius, 9)
    points = np.column_stack([x, np.zeros(9), TOP - radius + np.sqrt(radius**2 - x**2)])
    assert (stand_off(points, relief) < 0.05 * MM).all()


def test_parts_of_a_cloud_and_what_is_told_beside_it_keep_what_they_are_off_by():
    relief = over(edges(0.3, 1.5))
    cloud = with_stand_off(cloud_of(beside(np.array([-6.0, 1.0]) * MM), 1e-5), relief)
    assert cloud.part(np.array([False, True])).sd == pytest.approx(cloud.sd[1:])
    whole = told_points(cloud, relief)
    assert whole.sd[whole.seen > 0] == pytest.approx(cloud.sd)
    assert stand_off(np.zeros((0, 3)), relief).shape == (0,)
