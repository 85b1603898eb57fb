"""Surfaces whose depth is known in closed form, seen by cameras that stand and see as they should, and otherwise."""

import math

import numpy as np
import pytest

from stretch_bt.errors import InvalidInput
from stretch_bt.frames import Intrinsics, Pose
from stretch_bt.perception.deprojection import ray_table
from stretch_bt.simulation.camera.renderer import DepthRenderer
from stretch_bt.simulation.camera.skin import Grid, Plane, Profile, table_under
from stretch_bt.simulation.camera.view import RIGHT, SR305, Offset, View
from stretch_bt.simulation.effects.lens_distortion import LensDistortion
from stretch_bt.simulation.membrane.surface import Surface

DISTANCE = 0.2
BENT = LensDistortion(LensDistortion.Parameters()).lens(SR305)
OFF = Offset(0.003, -0.002, 0.005, 0.05, -0.08)
VIEWS = {
    "right": (SR305, RIGHT),
    "off": (SR305, OFF),
    "bent": (BENT, RIGHT),
    "bent and off": (BENT, OFF),
}


def bump(x, y):
    """Return a smooth height, m, with slopes up to 0.6."""
    return 0.010 * np.exp(-((x - 0.004) ** 2 + (y + 0.003) ** 2) / (2 * 0.011**2))


def grid(height, pitch=0.7e-3, width=0.09, length=0.12, waist=0.0):
    """Return a sheet over an even grid, narrower at its middle by a share `waist`."""
    u = np.linspace(-width / 2, width / 2, round(width / pitch) + 1)
    v = np.linspace(-length / 2, length / 2, round(length / pitch) + 1)
    x, y = np.meshgrid(u, v)
    x = x * (1 - waist * (1 - (y / (length / 2)) ** 2))
    return Grid(np.stack([x, y, height(x, y)], axis=-1))


def points(depth, lens, offset):
    """Return where in the membrane frame each pixel is, m."""
    seen = depth[..., None].astype(float) * ray_table(lens)
    view = View(lens, DISTANCE, offset)
    return seen @ view.turn + view.place


@pytest.mark.parametrize("name", VIEWS)
def test_every_pixel_of_a_grid_lies_on_its_surface(name):
    lens, offset = VIEWS[name]
    depth = DepthRenderer(lens, DISTANCE, offset).render(grid(bump))
    x, y, z = np.moveaxis(points(depth, lens, offset)[depth > 0], -1, 0)
    assert len(x) > 50000
    assert np.abs(z - bump(x, y)).max() < 0.3e-6
    assert abs(np.ptp(x) - 0.09) < 1e-3
    assert abs(np.ptp(y) - 0.12) < 1e-3


@pytest.mark.parametrize("name", VIEWS)
def test_every_pixel_of_a_profile_lies_on_it(name):
    lens, offset = VIEWS[name]
    surface = Surface(0.008, 0.006, 0.0025, 0.045, 0.015)
    surface = Surface(float(surface.depth - surface.height(0.045 * (1 - 1e-12))), 0.006, 0.0025, 0.045, 0.015)
    skin = Profile(surface, (0.002, -0.004), 0.09, 0.12)
    depth = DepthRenderer(lens, DISTANCE, offset).render(skin)
    x, y, z = np.moveaxis(points(depth, lens, offset)[depth > 0], -1, 0)
    assert len(x) > 50000
    assert np.abs(z - surface.height(np.hypot(x - 0.002, y + 0.004))).max() < 0.1e-6
    assert np.abs(x).max() <= 0.045 + 1e-9
    assert np.abs(y).max() <= 0.06 + 1e-9


@pytest.mark.parametrize("pitch", [2e-3, 1e-3, 0.5e-3])
def test_the_error_falls_with_the_fourth_power_of_the_pitch(pitch):
    depth = DepthRenderer(SR305, DISTANCE).render(grid(bump, pitch))
    x, y, z = np.moveaxis(points(depth, SR305, RIGHT)[depth > 0], -1, 0)
    assert np.abs(z - bump(x, y)).max() < 0.6e-6 * (pitch / 1e-3) ** 4


def test_the_table_shows_beside_the_sheet_and_the_fingers_hide_its_ends():
    skin = grid(bump, waist=0.1)
    bare = DepthRenderer(SR305, DISTANCE).render(skin)
    depth = DepthRenderer(SR305, DISTANCE).render(skin, Plane((0.0, 0.0, 1.0), -0.03))
    assert np.array_equal(depth[bare > 0], bare[bare > 0])
    rows = np.flatnonzero(bare.any(axis=1))
    beside = depth[rows[0] : rows[-1] + 1][bare[rows[0] : rows[-1] + 1] == 0]
    assert np.allclose(beside, 0.23, atol=1e-7)
    assert not depth[: rows[0]].any()
    assert not depth[rows[-1] + 1 :].any()
    waist = np.flatnonzero(bare[240])
    assert np.ptp(waist) == pytest.approx(0.081 / DISTANCE * SR305.fx, abs=2)


def test_a_renderer_keeps_nothing_of_the_view_before():
    wide, narrow = grid(bump), grid(bump, width=0.06)
    used = DepthRenderer(SR305, DISTANCE)
    for skin, below in ((wide, 0.03), (wide, 0.05), (wide, None), (narrow, 0.05), (wide, 0.03)):
        table = None if below is None else Plane((0.0, 0.0, 1.0), -below)
        assert np.array_equal(used.render(skin, table), DepthRenderer(SR305, DISTANCE).render(skin, table))


@pytest.mark.parametrize("rotation", [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, -0.15, 0.3)])
def test_the_table_under_a_tilted_hand_is_the_worlds_floor(rotation):
    hand = Pose((0.3, -0.1, 0.05), rotation)
    depth = DepthRenderer(SR305, DISTANCE).render(grid(bump), table_under(hand))
    bare = DepthRenderer(SR305, DISTANCE).render(grid(bump))
    seen = points(depth, SR305, RIGHT)[(depth > 0) & (bare == 0)]
    assert len(seen) > 10000
    world = (seen * [1.0, -1.0, 1.0]) @ hand.matrix().T + hand.position
    assert np.abs(world[:, 2]).max() < 1e-7


def test_both_ways_to_see_a_surface_agree(crop):
    from stretch_bt.simulation.camera.fold_kernel import look_through
    from stretch_bt.simulation.camera.renderer import _COLUMNS, _ROWS, _continued

    renderer = DepthRenderer(crop, DISTANCE)
    first = renderer.render(grid(bump, waist=0.1))
    column, row, depth = renderer.view.project(_continued(grid(bump, waist=0.1).points))
    second = np.zeros_like(first)
    look_through(column, row, depth, _ROWS, _COLUMNS, second)
    assert np.count_nonzero((first > 0) != (second > 0)) <= 5
    both = (first > 0) & (second > 0)
    assert np.abs(first - second)[both].max() < 0.5e-6


def test_a_surface_that_folds_over_shows_what_is_nearer():
    """A sheet that turns back under itself: from x = -30 to 20 mm at z = 10 mm, and back to -10 mm at z = 0."""
    s = np.linspace(0, 1, 161)
    x = np.interp(s, [0, 0.55, 0.65, 1], [-0.03, 0.02, 0.02, -0.01])
    z = np.interp(s, [0, 0.55, 0.65, 1], [0.01, 0.01, 0.0, 0.0])
    y = np.linspace(-0.03, 0.03, 61)
    sheet = np.stack(np.broadcast_arrays(x, y[:, None], z), axis=-1)
    depth = DepthRenderer(SR305, DISTANCE).render(Grid(sheet))
    seen = points(depth, SR305, RIGHT)[depth > 0]
    assert np.allclose(seen[seen[:, 0] < 0.0185][:, 2], 0.01, atol=1e-5)
    assert np.ptp(seen[:, 0]) == pytest.approx(0.05, abs=1e-3)


def test_a_bump_hides_what_lies_behind_it():
    """A steep ridge far to the side: behind it the camera sees nothing of the floor between its foot and its shadow."""
    steep = lambda x, y: 0.03 * np.exp(-(((x - 0.035) / 0.004) ** 4))  # noqa: E731
    depth = DepthRenderer(SR305, DISTANCE).render(grid(steep, 0.5e-3, width=0.12))
    line = points(depth, SR305, RIGHT)[240]
    line = line[depth[240] > 0]
    assert np.all(np.diff(line[:, 0] / (DISTANCE - line[:, 2])) > 0)
    jump = np.argmax(np.diff(line[:, 0]))
    assert line[jump, 2] > 0.015  # the ridge's edge ...
    shadow = line[jump, 0] * DISTANCE / (DISTANCE - line[jump, 2])
    assert line[jump + 1, 0] == pytest.approx(shadow, abs=1e-3)  # ... and the floor where its shadow ends


HARD = {
    "inside a grid's bulge": (grid(lambda x, y: 20 * bump(x, y)), SR305),
    "inside a profile's bulge": (Profile(Surface(0.195, 0.01, 0.0, 0.045, math.inf), (0.0, 0.0), 0.09, 0.1), SR305),
    "an empty crop": (grid(bump), SR305.cropped(100, 100, 50, 90)),
    "a crop beside the sheet": (grid(bump), SR305.cropped(0, 40, 0, 40)),
}


@pytest.mark.parametrize("name", HARD)
def test_a_camera_that_sees_nothing_says_so(name):
    skin, lens = HARD[name]
    depth = DepthRenderer(lens, DISTANCE).render(skin, Plane((0.0, 0.0, 1.0), -0.03))
    assert depth.shape == (lens.height, lens.width)
    assert depth.dtype == np.float32
    assert not depth.any()


@pytest.mark.parametrize("offset", [0.25, -0.2 + 1e-12, -1e4])
def test_a_table_that_the_camera_cannot_see_or_beyond_all_counts(offset):
    depth = DepthRenderer(SR305, DISTANCE).render(grid(bump), Plane((0.0, 0.0, 1.0), offset))
    assert np.isfinite(depth).all()
    assert (depth >= 0).all()
    assert depth[240, 320] == pytest.approx(0.2 - bump(0, 0), abs=2e-4)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: Grid(np.zeros((2, 9, 3))), "at least 3"),
        (lambda: Grid(np.zeros((9, 9))), "points"),
        (lambda: Grid(np.full((9, 9, 3), np.nan)), "finite"),
        (lambda: View(SR305, 0.2, Offset(z=-0.2)), "in front"),
    ],
)
def test_what_is_no_surface_and_no_camera_is_refused(made, said):
    with pytest.raises(InvalidInput, match=said):
        made()


@pytest.mark.parametrize("name", VIEWS)
def test_a_point_is_seen_by_the_pixel_whose_ray_meets_it(name):
    lens, offset = VIEWS[name]
    lens = Intrinsics(lens.fx, lens.fy, lens.cx, lens.cy, 640, 480, lens.distortion)
    view = View(lens, DISTANCE, offset)
    v, u = np.mgrid[60:420:40, 120:520:40]
    seen = points(np.full((480, 640), 0.19, np.float32), lens, offset)[v, u]
    np.testing.assert_allclose(view.project(seen), [u, v, np.full(u.shape, 0.19)], atol=2e-5)
