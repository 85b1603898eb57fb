"""What a frame may cost and hold: bounds of work, of intrinsics and kinds of numbers, and reasons that say what to try."""

import ast
import dataclasses
import re
import time
from pathlib import Path

import numpy as np
import pytest

import stretch_bt.perception
from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import average_frames, deproject, find_contact, mask_membrane, segment
from stretch_bt.perception.segmentation import classify
from stretch_bt.perception.smooth import gain, gaussian
from stretch_bt.perception.surface_kernel import fill_moves

H, W = 480, 640
LENS = Intrinsics(474.0, 474.0, 319.5, 239.5, W, H)
SECOND = 3.0  # s of CPU; a hang takes minutes, and a slow machine is no hang


def frame(raw, **changes):
    return DepthFrame(np.asarray(raw, np.uint16), 0.000125, changes.pop("lens", LENS), 0.0, 0, 0.2, **changes)


def four_far():
    raw = np.zeros((H, W))
    raw[[0, 0, -1, -1], [0, 1, 0, -1]] = 5600
    return raw


def salt(share, low=0, high=65535):
    rng = np.random.default_rng(0)
    return np.where(rng.random((H, W)) < share, rng.integers(low, high, (H, W)), 1600)


def bumps():
    u, v = (np.cos(2 * np.pi * np.arange(n) / 40) for n in (W, H))
    return np.rint(1560 - 40 * v[:, None] * u[None, :])


def stairs():
    return np.broadcast_to(1600 + 20 * (np.arange(W) // 80), (H, W))


def holes_in_holes():
    v, u = np.indices((H, W))
    return np.where(u & v, 1600, 1500)


COSTLY = {
    "stairs": stairs,
    "holes in holes": holes_in_holes,
    "four pixels": four_far,
    "salt": lambda: salt(0.3),
    "salt near": lambda: salt(0.5, 1000, 1800),
    "bumps": bumps,
    "at the lens": lambda: np.full((H, W), 16),
}


@pytest.mark.parametrize("rule", ["mean", "either"])
@pytest.mark.parametrize("name", COSTLY)
def test_no_frame_hangs(name, rule):
    made = frame(COSTLY[name]())
    began = time.process_time()
    try:
        find_contact(made, rule=rule)
    except (NoContact, IllConditioned, InvalidInput) as refused:
        assert len(str(refused)) > 20
    assert time.process_time() - began < SECOND


def test_hundreds_of_bulges_are_no_object():
    with pytest.raises(IllConditioned, match="separate places look curved"):
        classify(*deproject(frame(salt(0.3))), towards=-1)


def test_steps_across_the_whole_frame_are_no_membrane():
    with pytest.raises(IllConditioned, match="spread over the whole of the frame"):
        segment(*deproject(frame(stairs())))


def near_mean(points, valid, pitch):
    """As `fill_moves`, place by place."""
    h, w = valid.shape
    moves = points[..., :2] - pitch * np.stack(np.meshgrid(np.arange(w), np.arange(h)), axis=2)
    found = np.zeros((h, w, 2))
    for v, u in np.ndindex(h, w):
        reach = 0 if valid[v, u] else 2
        while reach < max(h, w):
            window = np.s_[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
            if valid[window].any():
                found[v, u] = moves[window][valid[window]].mean(axis=0)
                break
            reach = 2 * reach + 1
    return found


@pytest.mark.parametrize("share", [0.0, 0.002, 0.1, 0.9, 1.0])
def test_holes_take_the_mean_of_what_is_near(share):
    rng = np.random.default_rng(3)
    points, valid = rng.normal(size=(40, 50, 3)), rng.random((40, 50)) < share
    points[~valid] = np.nan
    x, y = np.empty((2, 40, 50), dtype=np.float32)
    fill_moves(points.reshape(40, 150), valid, 0, 0, 1, 0.1, x, y)
    np.testing.assert_allclose(np.stack([x, y], axis=2), near_mean(points, valid, np.float32(0.1)), atol=1e-5)


def test_the_gain_of_a_wide_filter_is_that_of_the_filter():
    orders = (2, 0, 1.0), (0, 2, 7.0)
    whole = sum(w * np.outer(gaussian(45.0, v), gaussian(45.0, u)) for u, v, w in orders)
    assert gain(45.0, *orders) == pytest.approx(np.sqrt((whole**2).sum()), rel=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {"fx": 0.0},
        {"fy": -474.0},
        {"fx": np.nan},
        {"cx": np.inf},
        {"distortion": (0.0, 0.0, np.nan, 0.0, 0.0)},
    ],
)
def test_intrinsics_that_no_camera_has_are_refused(changes):
    with pytest.raises(InvalidInput, match=r"intrinsics are finite|focal lengths are above 0"):
        dataclasses.replace(LENS, **changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"fx": 1e-3},
        {"cx": 1e12},
        {"distortion": (1e6, 0.0, 1e6, 0.0, 1e6)},
        {"distortion": (0.0, 0.0, 0.0, 0.0, 1e308)},
    ],
)
def test_rays_to_the_side_are_refused(changes):
    with pytest.raises(InvalidInput, match="aside for each metre ahead"):
        deproject(frame(np.full((H, W), 1600), lens=dataclasses.replace(LENS, **changes)))


def test_rays_that_are_all_one_are_refused():
    with pytest.raises(InvalidInput, match="from pixel to pixel"):
        find_contact(frame(np.full((H, W), 1600), lens=dataclasses.replace(LENS, fx=1e12)))


@pytest.mark.parametrize("name", ["unit", "plane_distance"])
@pytest.mark.parametrize("value", [0.0, -0.1, np.nan, np.inf])
def test_lengths_of_a_frame_are_above_zero(name, value):
    with pytest.raises(InvalidInput, match=name + " of a depth frame"):
        dataclasses.replace(frame(np.full((H, W), 1600)), **{name: value})


def test_a_mask_has_finite_sides():
    with pytest.raises(InvalidInput, match="finite"):
        mask_membrane(frame(np.full((H, W), 1600)), gauge=0.1, width=0.09, stretch=np.inf)


@pytest.mark.parametrize("kind", ["f2", ">f2", "f4", ">f4", "f8", ">f8", "g", "list"])
def test_depths_may_be_numbers_of_any_precision_and_order(kind):
    depth = np.full((20, 30), 0.25) + np.arange(30) / 1024
    given = depth.tolist() if kind == "list" else depth.astype(kind)
    points, valid = deproject(given, Intrinsics(40.0, 40.0, 15.0, 10.0, 30, 20))
    assert valid.all()
    assert points.dtype == (np.float32 if kind.endswith(("2", "4")) else np.float64)
    np.testing.assert_allclose(points[..., 2], depth, atol=1e-3 if kind.endswith("2") else 1e-7)
    assert segment(points.astype("g"), valid).shape == (20, 30)


@pytest.mark.parametrize("depth", [[[0.2, 0.2], [0.2]], "depth", None, [[1, 2]], np.zeros((2, 2), complex)])
def test_what_is_no_image_is_refused(depth):
    with pytest.raises(InvalidInput, match="depth image"):
        deproject(depth, Intrinsics(40.0, 40.0, 1.0, 1.0, 2, 2))


@pytest.mark.parametrize("name", ["stretch", "hand_height"])
def test_frames_of_a_hand_that_moves_are_not_averaged(name):
    still = dataclasses.replace(frame(np.full((H, W), 1600)), stretch=0.02, hand_height=0.1)
    within = dataclasses.replace(still, **{name: getattr(still, name) + 1e-3})
    beyond = dataclasses.replace(still, **{name: getattr(still, name) + 10e-3})
    unknown = dataclasses.replace(still, **{name: None})
    assert average_frames([still, within, unknown]).raw.any()
    with pytest.raises(IllConditioned, match="wait until the hand stands still"):
        average_frames([still, beyond])


REFUSALS = ("NoContact", "IllConditioned")
CAUGHT = "no bend"  # where it is raised
TRY = (
    "ask", "average", "begin", "choose", "compare", "fit", "free", "give", "hold", "keep", "label", "leave", "look", "measure", "move",
    "name", "press", "raise", "wait",
)  # fmt: skip


def refusals():
    for path in sorted(Path(stretch_bt.perception.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            match node:
                case ast.Raise(exc=ast.Call(func=ast.Name(id=name), args=[ast.Constant() | ast.JoinedStr() as text])):
                    if name in REFUSALS:
                        yield f"{path.name}:{node.lineno}", ast.unparse(text)


@pytest.mark.parametrize(("place", "text"), list(refusals()))
def test_a_refusal_says_what_to_try(place, text):
    advice = re.split(r"[;:] ", text)[1:]
    assert CAUGHT in text or any(part.lstrip("'\" ").startswith(TRY) for part in advice), (place, text)
