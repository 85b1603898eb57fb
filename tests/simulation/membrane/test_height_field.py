import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation import press
from stretch_bt.simulation.membrane.indenters.height_field import HeightField
from stretch_bt.simulation.membrane.indenters.parse import parse_indenter

FLAT = np.eye(3)


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


def hills(x, y):
    return 0.004 * np.cos(x / 0.0025) * np.cos(y / 0.003)


BALL = field(ball)


@pytest.mark.parametrize(
    "options",
    [{}, {"at": (0.012, 0.009)}, {"tilt": (0.2, -0.1)}, {"depth": 0.003}, {"at": (0.005, 0.0), "tilt": (0.0, 0.3)}],
)
def test_a_field_of_a_sphere_presses_like_the_sphere(options):
    arguments = {"stretch": 0.03, "depth": 0.008} | options
    found, sphere = press(BALL, **arguments), press("sphere:20mm", **arguments)
    assert found.force == pytest.approx(sphere.force, rel=0.01)
    assert found.balance < 1e-6


def test_distance_normal_and_curvature_are_those_of_the_sphere():
    rng = np.random.default_rng(7)
    normal = rng.normal(size=(3000, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal[normal[:, 2] > 0.6]
    for off in (-1e-3, -1e-4, 0.0, 1e-4, 2e-3, 0.02):
        gap = BALL.gap(normal * (0.01 + off))
        np.testing.assert_allclose(gap.distance, off, atol=2e-7)
        np.testing.assert_allclose(gap.normal, normal, atol=2e-3)
        trace = gap.curvature[:, 0] + gap.curvature[:, 3] + gap.curvature[:, 5]
        assert np.median(np.abs(trace * (0.01 + off) / 2 - 1)) < 1e-3


def test_the_nearest_point_is_the_nearest_of_all():
    ground = field(hills, 61, 0.25e-3)
    rng = np.random.default_rng(8)
    points = rng.uniform([-0.009, -0.009, -0.003], [0.009, 0.009, 0.012], (1500, 3))
    distance = ground.gap(points).distance
    x = np.linspace(-0.0075, 0.0075, 601)
    surface = np.stack([*np.meshgrid(x, x), hills(*np.meshgrid(x, x))], axis=-1).reshape(-1, 3)
    from scipy.spatial import cKDTree

    away = cKDTree(surface).query(points)[0]
    outside = distance > 0
    inside_grid = np.abs(points[:, :2]).max(axis=1) < 0.0075
    over = outside & inside_grid & (points[:, 2] > hills(points[:, 0], points[:, 1]))
    assert over.sum() > 300
    np.testing.assert_allclose(distance[over], away[over], atol=3e-5)
    close = points + rng.normal(0, 2e-4, points.shape)
    change = np.abs(ground.gap(close).distance - distance)
    assert np.all(change <= np.linalg.norm(close - points, axis=1) * (1 + 1e-6) + 1e-9)


def test_walls_end_it_and_nothing_is_beside_it():
    block = field(lambda x, y: np.full(x.shape, 0.003), 21, 1e-3)
    points = np.array(
        [[0.013, 0.0, 0.001], [0.013, 0.014, -1.0], [0.013, 0.0, 0.007], [0.0, 0.0, 0.004], [0.009, 0.0, 0.0]]
    )
    gap = block.gap(points)
    np.testing.assert_allclose(gap.distance, [0.003, 0.005, 0.005, 0.001, -0.001], atol=1e-12)
    expected = [[1, 0, 0], [0.6, 0.8, 0], [0.6, 0, 0.8], [0, 0, 1], [1, 0, 0]]
    np.testing.assert_allclose(gap.normal, expected, atol=1e-9)


@pytest.mark.parametrize(
    ("surface", "tip", "feature", "is_flat"),
    [
        (ball, 0.0085, 0.0085, False),  # at most half the grid
        (lambda x, y: -(x**2 + y**2) / 0.008, 0.004, 0.004, False),
        (lambda x, y: -(x**2) / 0.006 - 0 * y, 0.003, 0.003, False),  # a ridge
        (
            lambda x, y: -(np.maximum(np.hypot(x, y) - 0.005, 0.0) ** 2) / 0.002,
            0.0085,
            0.001,
            True,
        ),  # a face, a round rim
    ],
)
def test_size_and_shape_of_the_top(surface, tip, feature, is_flat):
    found = field(surface)
    assert found.tip_radius == pytest.approx(tip, rel=0.05)
    assert found.feature == pytest.approx(feature, rel=0.25)
    assert (found.flat > 0.004) == is_flat
    x, _ = found.zones(FLAT, 0.1)
    assert x[0].low == pytest.approx(-x[0].high)


def test_the_top_lies_between_the_nodes():
    found = field(lambda x, y: 0.005 - ((x - 1.1e-4) ** 2 + (y + 0.9e-4) ** 2) / 0.02)
    assert found.top(FLAT) == pytest.approx(0.005, abs=1e-9)
    assert found.crest(FLAT)[0] > 1e-3


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


@pytest.mark.parametrize(
    ("half", "depth", "surface"),
    [
        (0.003, 0.003, lambda x, y: -(x**2 + y**2) / 0.024),
        (0.006, 0.006, lambda x, y: -(x**2 + y**2) / 0.024),
        # a ridge from border to border
        pytest.param(0.008, 0.001, lambda x, y: -(x**2) / 0.02 + 0 * y, marks=pytest.mark.slow),
    ],
)
def test_a_sheet_that_rests_on_the_border_is_no_answer(half, depth, surface):
    bump = field(surface, round(2 * half / 0.25e-3) + 1)
    with pytest.raises(NoEquilibrium, match="border of the height field"):
        press(bump, 0.03, depth)


def test_a_file_of_heights(tmp_path):
    path = tmp_path / "a:b.npy"
    np.save(path, BALL.heights)
    assert parse_indenter(f"height:{path}:0.25mm") == BALL
    np.save(tmp_path / "words.npy", np.array(["high", "low"]))
    for text, says in (
        (f"height:{tmp_path}/none.npy:1mm", "No such file"),
        (f"height:{tmp_path}/words.npy:1mm", "heights"),
        ("height:part.npy", "pitch"),
        (f"height:{path}:0.25", "0.25 mm"),
    ):
        with pytest.raises(InvalidInput, match=says):
            parse_indenter(text)


@pytest.mark.parametrize(
    ("heights", "pitch"),
    [(np.zeros((3, 9)), 1e-3), (np.zeros(9), 1e-3), (np.full((5, 5), np.nan), 1e-3), (np.zeros((5, 5)), 0.0)],
)
def test_bad_input(heights, pitch):
    with pytest.raises(InvalidInput):
        HeightField(heights, pitch)


def test_steps_that_ring_are_refused():
    heights = np.full((41, 41), -0.02)
    heights[18:23, 18:23] = 0.0
    with pytest.raises(InvalidInput, match="rings"):
        HeightField(heights, 0.5e-3)
