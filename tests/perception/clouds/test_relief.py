"""The map of what was felt, its coverage and the choice of the next press, on sheets hung over known heights."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import Pose
from stretch_bt.perception.clouds.cloud import cloud_of
from stretch_bt.perception.clouds.coverage import coverage, hidden
from stretch_bt.perception.clouds.expected import drape
from stretch_bt.perception.clouds.next_view import next_view
from stretch_bt.perception.clouds.relief import add_view, carved, turn_of, view_of

MM = 1e-3
STEP = 1.25 * MM
U = (np.arange(72) + 0.5) * STEP - 45 * MM
V = (np.arange(80) + 0.5) * STEP - 50 * MM
SIZE = {"length": 100 * MM, "width": 90 * MM}


def box(x, y, half=(20 * MM, 20 * MM), top=30 * MM, at=(0.0, 0.0)):
    return np.where((np.abs(x - at[0]) < half[0]) & (np.abs(y - at[1]) < half[1]), top, 0.0)


def dome(x, y, radii=(25 * MM, 20 * MM), top=20 * MM, at=(0.0, 0.0)):
    return top * np.sqrt(np.maximum(1 - ((x - at[0]) / radii[0]) ** 2 - ((y - at[1]) / radii[1]) ** 2, 0.0))


def surface(ground, x, y, yaw, height):
    """Return a sheet over a ground, in the membrane frame, whose y runs against the hand's."""
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = U[:, None], V[None, :]
    sheet = drape(ground(x + c * u - s * v, y + s * u + c * v)[None], np.array([height]))[0]
    sheet, u, v = _finer(sheet), _finer(u + 0 * v), _finer(v + 0 * u)
    shape = sheet.shape
    return np.stack([np.broadcast_to(u, shape), np.broadcast_to(-v, shape), sheet - height], axis=2)


def _finer(values):
    """Return values halfway between the rows and the columns as well."""
    for axis in (0, 1):
        first, last = (
            np.take(values, range(*span), axis) for span in ((0, values.shape[axis] - 1), (1, values.shape[axis]))
        )
        both = np.stack([first, (first + last) / 2], axis=axis + 1)
        values = both.reshape([-1 if k == axis else n for k, n in enumerate(first.shape)])
    return values


def pressed(ground, x=0.0, y=0.0, yaw=0.0, height=15 * MM, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    poses = [Pose((x, y, h), (0.0, 0.0, yaw)) for h in (height, height + 2 * MM)]
    deep, shallow = (
        surface(ground, x, y, yaw, p.height) + [0, 0, 1] * rng.normal(0, 1, (142, 158, 1)) * noise for p in poses
    )
    return view_of(deep, shallow, deep_pose=poses[0], shallow_pose=poses[1], half_length=50 * MM)


def mapped(ground, *poses, **options):
    relief = None
    for pose in poses:
        relief = add_view(pressed(ground, *pose, **options), relief)
    return relief


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


def test_what_was_carved_is_not_hidden_and_what_was_felt_is_not_either():
    relief = mapped(dome, (0, 0, 0), height=6 * MM)
    left = hidden(relief)
    assert left.cells.any()
    assert not (left.cells & relief.felt).any()
    assert (relief.ceiling[left.cells] > left.height[left.cells]).all()
    assert np.isneginf(left.height[~(left.cells | relief.felt)]).all()


@settings(max_examples=6)
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
    assert np.hypot(look.x - x * MM, look.y - y * MM) > 8 * MM or apart > np.radians(30)
    assert 0 < look.gain < 1.3 * (left.cells.sum() + 40) * relief.cell**2
    assert look == next_view(relief, depth=0.65 * top * MM, **SIZE, x=span, y=span)


@settings(max_examples=3)
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


def test_nothing_is_planned_once_all_is_known():
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2), height=10 * MM)
    assert next_view(relief, depth=1 * MM, **SIZE) is None


@pytest.mark.parametrize(
    "moved",
    [
        {"top": 27 * MM},
        {"at": (9 * MM, 0.0)},
        {"at": (0.0, -9 * MM)},
        {"top": 33 * MM},
        {"half": (12 * MM, 12 * MM)},
    ],
)
def test_an_object_that_moved_between_presses_is_told_and_not_averaged_in(moved):
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2))
    with pytest.raises(IllConditioned, match="the object moved or gave way"):
        add_view(pressed(lambda x, y: box(x, y, **moved), yaw=0.1), relief)


@pytest.mark.parametrize("noise", [0.0, 0.15 * MM])
@pytest.mark.parametrize("pose", [(12 * MM, 0, 0), (0, -20 * MM, 1.0), (-8 * MM, 8 * MM, np.pi / 2)])
def test_an_object_that_stayed_is_not_said_to_have_moved(pose, noise):
    relief = mapped(box, (0, 0, 0), noise=noise)
    assert add_view(pressed(box, *pose, noise=noise, seed=1), relief).views == 2


def test_two_objects_are_two_pieces():
    def pair(x, y):
        return np.maximum(
            dome(x, y, (9 * MM,) * 2, 15 * MM, (-20 * MM, 0)), dome(x, y, (9 * MM,) * 2, 15 * MM, (20 * MM, 0))
        )

    assert mapped(pair, (0, 0, 0), (0, 0, np.pi / 2), height=4 * MM).pieces == 2


def test_a_contact_that_goes_on_to_a_clamp_is_cut_and_not_believed_there():
    view = pressed(lambda x, y: box(x, y, half=(20 * MM, 70 * MM)) - 0.5 * MM, height=26 * MM)
    assert view.cut
    relief = add_view(view)
    assert np.abs(relief.place(np.argwhere(relief.felt))[:, 1]).max() < 45 * MM
    assert not pressed(box).cut


def test_a_press_beside_the_object_only_carves():
    nothing = mapped(lambda x, y: 0 * x, (0, 0, 0))
    assert (nothing.felt_area, coverage(nothing), nothing.summit, nothing.pieces) == (0.0, 0.0, None, 0)
    with pytest.raises(NoContact, match="nothing was felt yet"):
        next_view(nothing, depth=10 * MM, **SIZE)


def test_a_cloud_loses_what_a_later_press_undercut():
    relief = mapped(box, (0, 0, 0), (0, 0, np.pi / 2))
    cloud = cloud_of(np.array([[0.0, 0.0, 30.0], [0.0, 25.0, 28.0], [0.0, 0.0, 34.0]]) * MM, 1e-4)
    assert carved(cloud, relief).points.tolist() == [[0.0, 0.0, 0.03]]


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
