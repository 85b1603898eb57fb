"""The map of what was felt, its coverage and the choice of the next press, on sheets hung over known heights."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import Pose
from stretch_bt.hardcases.domains.perception.sheets import box, dome, mapped, pressed, surface
from stretch_bt.perception.clouds.cloud import cloud_of
from stretch_bt.perception.clouds.coverage import coverage, hidden
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import add_view, carved
from stretch_bt.perception.clouds.seen import CellView, turn_of, view_of
from stretch_bt.perception.clouds.told import told, told_points

MM = 1e-3
SIZE = {"length": 100 * MM, "width": 90 * MM}


def test_two_presses_across_each_other_feel_a_box_up_to_its_edges_and_nothing_beside_it():
    once, twice = mapped(box, (0, 0, 0)), mapped(box, (0, 0, 0), (0, 0, np.pi / 2), noise=0.05 * MM)
    places = twice.place(np.argwhere(twice.felt))
    assert np.abs(places).max() < 22 * MM
    assert twice.felt_area == pytest.approx(1600e-6, rel=0.1)
    assert np.sqrt(np.mean((twice.height[twice.felt] - 30 * MM) ** 2)) < 0.4 * MM
    assert coverage(twice) > coverage(once)
    assert (twice.views, twice.pieces) == (2, 1)
    assert twice.poses == ((0, 0, 0), (0, 0, pytest.approx(np.pi / 2)))


def test_the_ceiling_is_nowhere_below_the_object():
    relief = mapped(dome, (5 * MM, 0, 0.3), (0, -10 * MM, 1.2), height=6 * MM)
    x, y = relief.place(np.argwhere(np.isfinite(relief.ceiling))).T
    # a cell holds the mean over 1 mm of a surface of slope up to 3 or so
    assert (relief.ceiling[np.isfinite(relief.ceiling)] - dome(x, y)).min() > -1.5 * MM


def test_what_was_carved_is_not_hidden_and_what_is_told_is_not_either():
    relief = mapped(dome, (0, 0, 0), height=6 * MM)
    left, known = hidden(relief), told(relief)
    assert left.cells.any()
    assert not (left.cells & known).any()
    assert (relief.ceiling[left.cells] > left.height[left.cells]).all()
    assert np.isneginf(left.height[~(left.cells | known)]).all()


def upper(ground, x, y):
    """Return where a ground is object, and at most as steep as what is looked for."""
    step = 0.05 * MM
    steep = np.hypot(ground(x + step, y) - ground(x, y), ground(x, y + step) - ground(x, y)) / step
    return (ground(x, y) > 0) & (steep < 1.0)


COVERED = {
    "box": box,
    "dome": dome,
    "steep dome": partial(dome, top=30 * MM),
    "narrow dome": partial(dome, radii=(12 * MM, 25 * MM)),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n not in ("box", "dome"))) for n in COVERED]
)
def test_the_share_that_is_stated_is_near_the_true_one(name):
    ground = COVERED[name]
    relief = mapped(
        ground, *[(0, y, yaw) for y, yaw in ((0, 0), (0, np.pi / 2), (-25 * MM, 0), (25 * MM, 0))], height=6 * MM
    )
    left = hidden(relief)
    x, y = relief.place(np.argwhere(np.ones(relief.felt.shape, bool))).T
    there = upper(ground, x, y).reshape(relief.felt.shape)
    assert coverage(relief, left) == pytest.approx((left.told & there).sum() / there.sum(), abs=0.12)


def test_hidden_surface_counts_by_how_much_room_is_left_below_the_membrane():
    relief = mapped(dome, (0, 0, 0), height=6 * MM)
    left = hidden(relief)
    assert ((left.chance > 0) <= left.cells).all()
    assert left.chance.max() <= 0.5, "what is as steep as 45 degrees or less, of all up to 90"
    assert left.chance[left.cells].min() < 0.2, "where the membrane hangs down beside it"
    assert coverage(relief, left) > left.told.sum() / (left.told | left.cells).sum()


BROAD = {
    "ridge": partial(box, half=(80 * MM, 4 * MM)),
    "slab": partial(box, half=(65 * MM, 20 * MM)),
}


@pytest.mark.parametrize("name", [pytest.param("ridge", marks=pytest.mark.slow), "slab"])
def test_what_goes_on_beyond_the_membrane_is_followed_and_no_finger_comes_down_on_it(name):
    ground, tried = BROAD[name], []
    relief = mapped(ground, (0, 0, 0), height=12 * MM)
    while coverage(relief, left := hidden(relief)) < 0.95:
        look = next_view(relief, depth=18 * MM, **SIZE, unseen=left, tried=tried)
        assert look is not None
        assert len(tried) < 8
        tried.append((look.x, look.y, look.yaw))
        relief = add_view(pressed(ground, *tried[-1], height=12 * MM), relief)
        across, along = np.meshgrid(np.linspace(-45, 45, 46) * MM, np.linspace(50, 65, 8) * MM)
        c, s = np.cos(look.yaw), np.sin(look.yaw)
        for side in (along, -along):
            assert ground(look.x + c * across - s * side, look.y + s * across + c * side).max() == 0
    x, y = relief.place(np.argwhere(left.told)).T
    assert len(tried) > 1
    assert (ground(x, y) > 0).sum() * relief.cell**2 > 0.9 * {"ridge": 160 * 8, "slab": 130 * 40}[name] * MM**2


def test_where_no_membrane_has_been_a_surface_surely_goes_on():
    relief = mapped(BROAD["slab"], (0, 0, 0), height=12 * MM)
    left = hidden(relief)
    beyond = left.cells & relief.unknown
    assert beyond.sum() > 300
    assert (left.chance[beyond] == 1).all()
    assert coverage(relief, left) < 0.9
    assert not (hidden(mapped(box, (0, 0, 0))).cells & mapped(box, (0, 0, 0)).unknown).any(), (
        "it ends under the membrane"
    )


@settings(max_examples=4)
@given(
    st.floats(14, 30),
    st.floats(14, 30),
    st.floats(12, 30),
    st.floats(-10, 10),
    st.floats(-10, 10),
    st.floats(-1.5, 1.5),
)
def test_the_next_press_is_in_bounds_new_and_shows_no_more_than_is_hidden(a, b, top, x, y, yaw):
    def ground(u, v):
        return dome(u, v, (a * MM, b * MM), top * MM)

    relief = mapped(ground, (x * MM, y * MM, yaw), height=0.35 * top * MM)
    left = hidden(relief)
    assert 0 <= coverage(relief, left) <= 1
    span = (-25 * MM, 12 * MM)
    look = next_view(relief, depth=0.65 * top * MM, **SIZE, x=span, y=span)
    if look is None:
        return
    assert span[0] <= min(look.x, look.y) <= max(look.x, look.y) <= span[1]
    apart = abs((look.yaw - yaw + np.pi / 2) % np.pi - np.pi / 2)
    assert np.hypot(look.x - x * MM, look.y - y * MM) > 5 * MM or apart > np.radians(30)
    assert 0 < look.gain < 1.3 * (left.cells.sum() + 40) * relief.cell**2
    assert look == next_view(relief, depth=0.65 * top * MM, **SIZE, x=span, y=span)


@settings(max_examples=2)
@given(st.floats(15, 28), st.floats(15, 28))
def test_planned_presses_cover_more_and_more_of_a_dome(a, b):
    def ground(u, v):
        return dome(u, v, (a * MM, b * MM), 20 * MM)

    relief, areas = mapped(ground, (0, 0, 0), height=6 * MM), []
    for _ in range(3):
        areas.append(relief.felt_area)
        look = next_view(relief, depth=14 * MM, **SIZE)
        if look is None:
            break
        relief = add_view(pressed(ground, look.x, look.y, look.yaw, 6 * MM), relief)
    assert relief.felt_area >= areas[0]
    assert coverage(relief) > 0.4


def domes(x, y):
    return np.maximum(dome(x, y, (14 * MM, 14 * MM), at=(-22 * MM, 0)), dome(x, y, (14 * MM, 14 * MM), at=(22 * MM, 0)))


TOLD = {
    "box": (box, 0.97),
    "dome": (dome, 0.5),
    "ridge": (partial(box, half=(25 * MM, 1 * MM)), 1.0),
    "domes": (domes, 0.2),
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.slow] * (n in ("box", "dome"))) for n in TOLD])
def test_what_is_told_beside_what_was_felt_lies_on_the_object_or_just_beside_it(name):
    ground, least = TOLD[name]
    relief = mapped(
        ground, *[(0, y, yaw) for y, yaw in ((0, 0), (0, np.pi / 2), (-25 * MM, 0), (25 * MM, 0))], height=8 * MM
    )
    known, every = told(relief), np.ones(relief.felt.shape, bool)
    x, y = relief.place(np.argwhere(every)).T
    truth = ground(x, y).reshape(every.shape)
    on = known & (truth > 0)
    assert on.sum() >= least * (truth > 0).sum()
    assert (known & ~relief.felt).any()
    assert np.sqrt(np.mean((relief.ceiling - truth)[on] ** 2)) < 0.5 * MM
    assert not (known & ~binary_dilation(truth > 0, iterations=4)).any()
    middle = (np.abs(x) < 5 * MM).reshape(every.shape)
    assert name != "domes" or not (known & middle).any(), "between them it hangs"


@pytest.mark.parametrize(("inside", "spans"), [(0.6 * MM, True), (-0.6 * MM, True), (-3 * MM, False)])
def test_a_membrane_that_spans_a_rim_about_as_high_tells_a_face_whatever_lifted_it_off(inside, spans):
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2))
    away = np.abs(relief.place(np.argwhere(relief.felt | True))).max(axis=1).reshape(relief.felt.shape)
    drum = away < 15 * MM
    relief.ceiling[drum] = 30 * MM + inside
    lifted = replace(relief, hung=np.where(drum, 3.0, relief.hung))
    assert not (lifted.felt & drum).any()
    assert told(lifted)[drum].all() == spans
    assert not spans or coverage(lifted) == pytest.approx(coverage(relief), abs=0.02)


def test_a_cloud_gains_a_point_in_each_cell_that_is_told_and_loses_specks():
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2))
    cloud = cloud_of(np.array([[0.0, 0.0, 30.0], [0.0, 60.0, 28.0]]) * MM, 1e-4)
    whole, known = told_points(cloud, relief), told(relief)
    assert len(whole) == known.sum()
    assert whole.points[0].tolist() == cloud.points[0].tolist()
    assert (whole.seen[0], whole.seen[1:].max()) == (1, 0)
    assert whole.sd[1:] == pytest.approx(1 * MM, rel=0.01)
    assert told_points(replace(cloud, scatter=9.0, repeats=1), relief).sd[1:] == pytest.approx(1 * MM, rel=0.01)
    assert np.isin(whole.points[1:, 2], relief.ceiling[known]).all()


def test_nothing_is_planned_once_all_is_known():
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2), height=10 * MM)
    assert next_view(relief, depth=1 * MM, **SIZE) is None


@pytest.mark.parametrize("noise", [0.0, 0.15 * MM])
@pytest.mark.parametrize("pose", [(12 * MM, 0, 0), (0, -20 * MM, 1.0), (-8 * MM, 8 * MM, np.pi / 2)])
def test_an_object_that_stayed_is_not_said_to_have_moved(pose, noise):
    relief = mapped(box, (0, 0, 0), noise=noise)
    assert add_view(pressed(box, *pose, noise=noise, seed=1), relief).views == 2


ROUND = [(0, 0, 0), (0, 0, np.pi / 2), (10 * MM, 0, 0)]


@pytest.mark.parametrize("views", [1, pytest.param(2, marks=pytest.mark.slow), 3])
def test_an_object_that_moved_is_told_however_many_presses_there_were(views):
    relief = mapped(box, *ROUND[:views])
    with pytest.raises(IllConditioned, match="moved or gave way"):
        add_view(pressed(partial(box, at=(14 * MM, 0.0))), relief)


def test_what_one_of_several_presses_took_for_contact_does_not_move_an_object():
    relief = mapped(box, *ROUND)
    beside = np.pad(np.zeros(relief.felt.shape, bool), 40)
    beside[26:39, 45:65] = True
    wrong = tuple(np.pad(values, 40) for values in (relief.weight, relief.height, relief.hung))
    ceiling = np.where(beside, 30 * MM, np.pad(relief.ceiling, 40, constant_values=np.inf))
    origin = (relief.origin[0] - 40, relief.origin[1] - 40)
    once = replace(
        relief,
        origin=origin,
        ceiling=ceiling,
        weight=np.where(beside, 1.0, wrong[0]),
        height=np.where(beside, 30 * MM, wrong[1]),
        hung=wrong[2],
    )
    places = once.place(np.argwhere(beside))
    lower = CellView(
        np.argwhere(beside) + origin,
        np.full(len(places), 20 * MM),
        np.zeros(len(places), bool),
        np.zeros(len(places), bool),
    )
    assert not add_view(lower, once).felt[beside].any(), "it is taken back"
    with pytest.raises(IllConditioned, match="moved or gave way"):
        add_view(lower, replace(once, weight=np.where(beside, 2.0, wrong[0])))


@pytest.mark.parametrize("share", [0.3, 0.8])
def test_what_seems_to_touch_above_what_was_felt_says_that_it_rose_only_where_little_is_felt_again(share):
    relief, view = mapped(box, *ROUND), pressed(box)
    bridge = view.touched & (view.cells[:, 0] < np.quantile(view.cells[view.touched, 0], share))
    above = replace(view, heights=view.heights + 2 * MM * bridge)
    if share < 0.5:
        kept = add_view(above, relief)
        assert np.abs(kept.height[kept.felt] - 30 * MM).max() < 1 * MM, "nor is it averaged in"
    else:
        with pytest.raises(IllConditioned, match="moved or gave way"):
            add_view(above, relief)


@settings(max_examples=2)
@given(st.floats(14, 28), st.floats(14, 28), st.floats(16, 30))
def test_no_finger_is_planned_over_what_was_felt_and_none_where_it_was_tried(a, b, top):
    def ground(u, v):
        return dome(u, v, (a * MM, b * MM), top * MM)

    relief, tried = mapped(ground, (0, 0, 0), height=0.35 * top * MM), []
    for _ in range(3):
        look = next_view(relief, depth=0.65 * top * MM, **SIZE, tried=tried)
        if look is None:
            break
        assert all(np.hypot(look.x - x, look.y - y) > 5 * MM or abs(look.yaw - yaw) > 0.5 for x, y, yaw in tried)
        tried.append((look.x, look.y, look.yaw))
        away = relief.place(np.argwhere(relief.felt)) - [look.x, look.y]
        along = np.abs(away @ [-np.sin(look.yaw), np.cos(look.yaw)])
        under = (np.abs(away @ [np.cos(look.yaw), np.sin(look.yaw)]) < 45 * MM) & (along > 50 * MM) & (along < 65 * MM)
        assert not under.any()


def test_a_cloud_loses_what_a_later_press_undercut():
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2))
    cloud = cloud_of(np.array([[0.0, 0.0, 30.0], [0.0, 25.0, 28.0], [0.0, 0.0, 34.0]]) * MM, 1e-4)
    assert carved(cloud, relief).points.tolist() == [[0.0, 0.0, 0.03]]


@pytest.mark.parametrize(("turn", "other"), [(0.0, False), (np.pi, False), (-np.pi, False), (np.pi / 2, True)])
def test_half_a_turn_is_no_other_pose(turn, other):
    view = pressed(box)
    again = add_view(replace(view, pose=(0.0, 0.0, turn)), add_view(view))
    assert np.isfinite(again.second).any() == other


def test_what_carries_no_view_is_refused():
    flat = surface(box, 0, 0, 0, 15 * MM)
    low, high = Pose((0, 0, 15 * MM)), Pose((0, 0, 17 * MM))
    with pytest.raises(IllConditioned, match=r"hand rose by 0\.00 mm"):
        view_of(flat, flat, deep_pose=low, shallow_pose=low, half_length=50 * MM)
    with pytest.raises(NoContact, match="no valid pixel"):
        view_of(flat * np.nan, flat, deep_pose=low, shallow_pose=high, half_length=50 * MM)
    view = pressed(box)
    with pytest.raises(InvalidInput, match="cells of"):
        add_view(view, add_view(view), cell=2 * MM)
    with pytest.raises(InvalidInput, match="above 0 m"):
        next_view(add_view(view), depth=0.0, **SIZE)


def test_the_turn_of_a_hand():
    assert turn_of(Pose(rotation=(0.0, 0.0, -1.2))) == pytest.approx(-1.2)
