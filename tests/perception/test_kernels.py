"""Compiled passes against what they say, written plainly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.perception import MASKS
from stretch_bt.perception.contact_kernel import fill_touching
from stretch_bt.perception.deprojection import view_rays
from stretch_bt.perception.noise_spectrum_kernel import descend, fill_cells
from stretch_bt.perception.regions import border, with_rim
from stretch_bt.perception.regions_kernel import draw
from stretch_bt.perception.surface_kernel import fill_along
from stretch_bt.perception.top_kernel import settle


@given(MASKS, st.sampled_from([1, 2, 4]), st.integers(0, 5), st.integers(0, 2**32 - 1))
def test_a_patch_is_drawn_by_bins_and_along_its_border_by_the_score(masks, step, cut, seed):
    mask, held = masks
    inner, outer = border(mask)
    score = np.random.default_rng(seed).normal(size=(mask.shape[0] * step, mask.shape[1] * step)).astype(np.float32)
    place = held.repeat(step, axis=0).repeat(step, axis=1)[: max(1, len(score) - cut), : max(1, score.shape[1] - cut)]
    wide, all_of = (m.repeat(step, axis=0).repeat(step, axis=1) for m in (outer, inner))
    wanted = place | (all_of | (wide & (score > 0)))[: place.shape[0], : place.shape[1]]
    found = place.copy()
    draw(inner, outer, score, step, found)
    np.testing.assert_array_equal(found, wanted)


@given(MASKS)
def test_a_mask_with_its_rim_is_that_of_its_border(masks):
    np.testing.assert_array_equal(with_rim(masks[0]), border(masks[0])[1])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_points_in_contact_come_with_their_rays(dtype):
    rng = np.random.default_rng(0)
    points, labels = rng.normal(size=(500, 3)).astype(dtype), rng.choice([0, 1, 2, 255], 500).astype(np.uint8)
    wanted, left = points[labels == 2], points.copy()
    left[labels == 255] = np.nan
    found, rays = np.empty((2, *wanted.shape), dtype=dtype)
    fill_touching(points, labels, 0.2, found, rays)
    np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(rays, view_rays(wanted, (0.0, 0.0, 0.2)))
    np.testing.assert_array_equal(points, left)


def test_curvatures_along_both_axes_are_normal_curvatures():
    rng = np.random.default_rng(1)
    x, y, xx, yy = rng.normal(size=(4, 20, 30)).astype(np.float32)
    trusted, i, j = rng.random((20, 30)) < 0.8, np.empty((20, 30), np.float32), np.empty((20, 30), np.float32)
    fill_along(x, y, xx, yy, trusted, i, j)
    root = np.sqrt(np.float32(1) + x * x + y * y)
    np.testing.assert_array_equal(i, np.where(trusted, -xx / ((np.float32(1) + x * x) * root), 0))
    np.testing.assert_array_equal(j, np.where(trusted, -yy / ((np.float32(1) + y * y) * root), 0))


@pytest.mark.parametrize("step", [1, 2, 5])
def test_cells_hold_the_sums_of_their_pixels(step):
    rng = np.random.default_rng(2)
    rows, columns, design = rng.integers(7, 40, 300), rng.integers(3, 60, 300), rng.normal(size=(4, 300))
    v, u = (rows - rows.min()) // step, (columns - columns.min()) // step
    found, wanted = np.zeros((2, 4, v.max() + 1, u.max() + 1))
    fill_cells(design, rows, columns, step, found)
    for k in range(4):
        np.add.at(wanted[k], (v, u), design[k])
    np.testing.assert_array_equal(found, wanted)


def test_least_squares_that_are_not_negative_are_those_of_scipy():
    from scipy.optimize import nnls

    rng = np.random.default_rng(3)
    for _ in range(20):
        design, wanted, q = rng.normal(size=(12, 5)), rng.normal(size=12), np.zeros(5)
        design /= np.linalg.norm(design, axis=0)
        descend(design.T @ design, design.T @ wanted, np.ones(5, dtype=bool), 4000, 1e-12, q)
        np.testing.assert_allclose(q, nnls(design, wanted)[0], atol=1e-8)


@pytest.mark.parametrize("parameters", [1, 3, 4, 6])
def test_reweighted_least_squares_settle_where_weighted_ones_do(parameters):
    rng = np.random.default_rng(4)
    x, y = rng.normal(size=(2, 200))
    design = np.stack([np.ones(200), x, y, -0.5 * x * x, -x * y, -0.5 * y * y])[:parameters].copy()
    z, q = rng.normal(size=200) + design.sum(axis=0), np.zeros(parameters)
    assert settle(design, z, q, np.inf, np.inf, 8)
    np.testing.assert_allclose(q, np.linalg.lstsq(design.T, z)[0], rtol=1e-9)
    assert settle(design, z, q, 4.0, 1e-14, 100)
    weights = np.maximum(1 - ((z - q @ design) / 4.0) ** 2, 0) ** 2
    normal = (design * weights) @ design.T
    np.testing.assert_allclose(q, np.linalg.solve(normal, design @ (weights * z)), rtol=1e-9)
