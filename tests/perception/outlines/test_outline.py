import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.accuracy.perception import outlines
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.perception import circularity, outline_of

PITCH = outlines.PITCH
SHAPES = ("disc", "oval", "square", "triangle")


@pytest.mark.parametrize("size", [25e-3, pytest.param(60e-3, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("shape", "jitter", "limit"),
    [("disc", 0, 2e-3), ("oval", 0, 2e-3), ("square", 0, 0.01), ("triangle", 0, 0.01)]
    + [("disc", 1, 0.02), ("oval", 1, 0.02), ("square", 1, 0.05), ("triangle", 1, 0.05)]
    + [
        pytest.param(*case, marks=pytest.mark.slow)
        for case in (("disc", 0.3, 0.01), ("oval", 0.3, 0.01), ("square", 0.3, 0.04), ("triangle", 0.3, 0.03))
    ],
)
def test_circularity_of_the_contour_is_right_with_and_without_jitter(shape, size, jitter, limit):
    clean = outlines.outline(shape, size)
    truth = outlines.true_circularity(shape)
    for seed in range(10 if jitter else 1):
        vertices = outlines.jittered(clean, jitter * PITCH, seed)
        assert abs(circularity(vertices) - truth) < limit


@pytest.mark.parametrize("method", ["contour", "low_pass", "pixel_chain"])
@pytest.mark.parametrize("shape", ["disc", pytest.param("square", marks=pytest.mark.slow)])
def test_circularity_states_its_spread(shape, method):
    """And of a contour what smoothing leaves of the noise, which makes it longer."""
    clean = outlines.outline(shape)
    found = [circularity(outlines.jittered(clean, PITCH, seed), method=method) for seed in range(20)]
    truth = outlines.true_circularity(shape) if method == "contour" else np.mean(found)
    assert 0.45 < np.mean([f.sd for f in found]) / np.sqrt(np.mean(np.square(np.array(found) - truth))) < 2.2


@pytest.mark.parametrize(("long", "count", "noise"), [(1.0, 400, 0.02), (1.0, 150, 0.03), (1.5, 400, 0.02)])
def test_rough_outlines_are_longer_by_what_is_stated(long, count, noise):
    """Of samples that err by 2 % of the radius the error was 6 to 12 stated deviations."""
    fine, turn = (2 * np.pi * np.arange(n) / n for n in (20000, count))
    truth = circularity(np.column_stack([long * np.cos(fine), np.sin(fine)]))
    parts = []
    for seed in range(12):
        away = 1 + np.random.default_rng(seed).normal(0, noise, count)
        found = circularity(np.column_stack([long * np.cos(turn), np.sin(turn)]) * away[:, None])
        parts.append((found - truth) / found.sd)
    assert 0.6 < np.sqrt(np.mean(np.square(parts))) < 1.5


def test_the_other_methods_score_what_is_known_of_them():
    assert 0.885 < circularity(outlines.outline("disc", 60e-3), method="pixel_chain") < 0.905
    assert circularity([[0, 0], [1, 0], [1, 1], [0, 1]], method="low_pass") == pytest.approx(0.844, abs=1e-3)
    assert circularity(outlines.outline("disc"), method="low_pass") == pytest.approx(1.0, abs=1e-3)
    chain = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]])
    assert circularity(chain, method="pixel_chain") == pytest.approx(np.pi / 4)


@pytest.mark.parametrize("corners", [3, 4, 5, 8, 15])
def test_few_vertices_are_the_corners_of_a_polygon(corners):
    turn = 2 * np.pi * np.arange(corners) / corners
    found = circularity(np.column_stack([np.cos(turn), np.sin(turn)]))
    assert found == pytest.approx(np.pi / corners / np.tan(np.pi / corners))
    assert found.sd == 0.0


@settings(max_examples=12)
@given(
    scale=st.floats(1e-4, 1e4),
    shift=st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
    angle=st.floats(0, 2 * np.pi),
    first=st.integers(0, 100),
    backwards=st.booleans(),
    closed=st.booleans(),
    shape=st.sampled_from(SHAPES),
)
def test_circularity_does_not_depend_on_unit_place_turn_start_or_sense(
    scale, shift, angle, first, backwards, closed, shape
):
    vertices = outlines.jittered(outlines.outline(shape), 0.5 * PITCH, 1)
    before = circularity(vertices)
    c, s = np.cos(angle), np.sin(angle)
    moved = scale * (np.roll(vertices, first, axis=0) @ [[c, s], [-s, c]] + np.multiply(shift, 25e-3))
    moved = moved[::-1] if backwards else moved
    moved = np.vstack([moved, moved[:1]]) if closed else moved
    assert circularity(moved) == pytest.approx(float(before), abs=2e-3)


def test_uneven_vertices_are_sampled_anew():
    turn = np.linspace(-np.pi / 2, np.pi / 2, 100)
    half_disc = np.column_stack([np.cos(turn), np.sin(turn)])
    truth = 4 * np.pi * (np.pi / 2) / (np.pi + 2) ** 2
    assert circularity(half_disc) == pytest.approx(truth, abs=0.01)
    assert circularity(half_disc, method="low_pass") == pytest.approx(truth, abs=0.05)


@pytest.mark.parametrize("flips", [pytest.param(0.0, marks=pytest.mark.slow), 0.25])
@pytest.mark.parametrize(
    ("shape", "limit"),
    [("disc", 0.02), pytest.param("oval", 0.02, marks=pytest.mark.slow), ("square", 0.035)],
)
def test_outline_of_a_mask(shape, flips, limit):
    found = [outline_of(outlines.mask(shape, seed=seed, flips=flips), PITCH) for seed in range(10)]
    area = np.array([o.area for o in found])
    stated = np.mean([o.area_sd for o in found])
    assert np.abs(area / outlines.true_area(shape) - 1).max() < 0.01
    assert 0.4 < stated / np.sqrt(np.mean((area - outlines.true_area(shape)) ** 2)) < 2.5
    truth = outlines.true_circularity(shape)
    for o in found:
        assert abs(o.roundness().circularity - truth) < limit
        assert o.roundness("pixel_chain").method == "pixel_chain"
    perimeter = np.sqrt(4 * np.pi * outlines.true_area(shape) / truth)
    assert np.mean([o.perimeter for o in found]) == pytest.approx(perimeter, rel=0.02)


def test_outline_follows_the_points_of_the_pixels_and_bridges_dropouts():
    region = outlines.mask("oval", seed=3)
    v, u = np.mgrid[: region.shape[0], : region.shape[1]]
    points = np.stack([0.5e-3 * u - 2e-5 * v, 0.3e-3 * v + 0.01, 0.0 * u], axis=2)
    labels = np.where(region, 2, 1).astype(np.uint8)
    gone = np.random.default_rng(0).random(labels.shape) < 0.03
    labels[gone] = 255
    points[gone] = np.nan
    found = outline_of(labels, points)
    assert found.area == pytest.approx(outlines.true_area("oval") / PITCH**2 * 0.5e-3 * 0.3e-3, rel=0.01)
    inside = points[region & ~gone][:, :2]
    assert np.abs(found.vertices.mean(axis=0) - inside.mean(axis=0)).max() < 0.2e-3


def test_a_region_without_an_outline_is_refused():
    region = outlines.mask("disc")
    middle = region.shape[0] // 2
    with pytest.raises(NoContact, match="no pixel"):
        outline_of(np.zeros_like(region), PITCH)
    with pytest.raises(IllConditioned, match="edge of the image cuts"):
        outline_of(region[middle:], PITCH)
    split = region.copy()
    split[middle - 2 : middle + 2] = False
    with pytest.raises(IllConditioned, match="pieces"):
        outline_of(split, PITCH)
    with pytest.raises(IllConditioned, match="pixels; an outline"):
        outline_of(region[::12, ::12], PITCH)
    labels = np.where(region, 2, 0).astype(np.uint8)
    labels[middle + 5 :] = 255
    with pytest.raises(IllConditioned, match="no depth"):
        outline_of(labels, PITCH)
    speck = region.copy()
    speck[2:5, 2:5] = True
    assert outline_of(speck, PITCH).area == pytest.approx(outline_of(region, PITCH).area)


def test_bad_arguments_say_what_was_expected():
    region = outlines.mask("disc")
    with pytest.raises(InvalidInput, match="one of contour, pixel_chain, low_pass"):
        circularity(outlines.outline("disc"), method="crofton")
    with pytest.raises(InvalidInput, match="bool"):
        outline_of(region.astype(float), PITCH)
    with pytest.raises(InvalidInput, match="positive"):
        outline_of(region, 0.0)
    with pytest.raises(InvalidInput, match="shape"):
        outline_of(region, np.zeros((3, 4, 3)))


def test_the_perimeter_of_straight_borders_of_pixels_has_an_error():
    """A square along the pixels shows no roughness, and stated 1e-14 mm."""
    region = np.zeros((100, 100), dtype=bool)
    region[30:70, 30:70] = True
    found = outline_of(region, 0.5e-3)
    assert abs(found.perimeter - 80e-3) < 2.0 * found.perimeter_sd < 4e-3
    assert found.perimeter == pytest.approx(80e-3, abs=2.5e-3)


@pytest.mark.parametrize(("corners", "size"), [(0, 15), (0, 60), (4, 30), (4, 60), (6, 30), (6, 60)])
def test_a_circularity_of_drawn_pixels_is_off_by_what_it_states(corners, size):
    """Stairs and the blur of corners were not counted: errors were 3 to 22 times what was stated."""
    y, x = np.indices((4 * size, 4 * size)) - 2.0 * size
    ratios = []
    for seed in range(8):
        (u, v), turn = (rng := np.random.default_rng(seed)).uniform(-0.5, 0.5, 2), rng.uniform(0, np.pi)
        normals = turn + 2 * np.pi * np.arange(corners) / max(corners, 1)
        far = [(x - u) * np.cos(angle) + (y - v) * np.sin(angle) for angle in normals] or [np.hypot(x - u, y - v)]
        found = outline_of(np.max(far, axis=0) <= size, 1.0).roundness()
        truth = np.pi / corners / np.tan(np.pi / corners) if corners else 1.0
        ratios.append((found.circularity - truth) / found.circularity_sd)
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.5
