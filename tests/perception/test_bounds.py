"""What a frame may cost and hold: bounds of work, of intrinsics and kinds of numbers, and reasons that say what to try."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import stretch_bt.perception
from stretch_bt.errors import NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import find_contact, leaning, segmentation, track_height
from stretch_bt.perception.shapes import contact_search
from stretch_bt.perception.smooth import gain, gaussian
from stretch_bt.perception.surface_kernel import fill_moves
from stretch_bt.perception.types import CONTACT


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


def disc(radius):
    """Points (480, 640, 3) and labels of a flat top, 10 mm high, on a flat membrane, under 0.1 mm of noise."""
    v, u = np.indices((480, 640))
    touching = (v - 240) ** 2 + (u - 320) ** 2 < radius**2
    z = np.where(touching, 10e-3, 0.0) + np.random.default_rng(0).normal(0.0, 1e-4, touching.shape)
    points = np.stack([(u - 320) * 4e-4, (240 - v) * 4e-4, z], axis=2).astype(np.float32)
    return points, np.where(touching, CONTACT, 0).astype(np.uint8)


def called_with(monkeypatch, module, name):
    """Return a list that grows by the arguments of each call of a function of a module."""
    calls, real = [], getattr(module, name)
    monkeypatch.setattr(module, name, lambda *these, **named: calls.append(these) or real(*these, **named))
    return calls


def test_the_plane_of_a_wide_face_is_sought_in_some_of_its_means(monkeypatch):
    points, labels = disc(radius=200)
    calls = called_with(monkeypatch, leaning, "settled")
    found = track_height(points, np.ones(labels.shape, dtype=bool), labels)
    assert abs(found.value - 10e-3) < 4 * found.sd < 1e-4
    assert len(calls) > 1
    assert sum(heights.size > leaning.MOST for _, heights in calls) == 1  # at the end


def test_noise_is_not_sought_where_nothing_stands_up(monkeypatch):
    lens = Intrinsics(480.0, 480.0, 319.5, 239.5, 640, 480)
    raw = np.rint(np.random.default_rng(0).normal(0.2, 3e-4, (480, 640)) / 0.125e-3).astype(np.uint16)
    calls = called_with(monkeypatch, segmentation, "noise_spectrum")
    with pytest.raises(NoContact):
        find_contact(DepthFrame(raw, 0.125e-3, lens, 0.0, 0, 0.2))
    assert not calls


def test_the_noise_of_a_wide_window_is_seen_in_its_middle():
    v, u = np.indices((480, 640))
    away = np.hypot(v - 240, u - 320)
    rows, columns = contact_search._seen_box(away < 230)
    assert (rows.start + rows.stop) // 2 == 240
    assert (columns.start + columns.stop) // 2 == 320
    assert rows.stop - rows.start == columns.stop - columns.start == contact_search.MOST_SIDE
    assert contact_search._seen_box((away < 230) & (away > 150)) == (slice(11, 470), slice(91, 550))
    assert contact_search._seen_box(away < 60) == (slice(181, 300), slice(261, 380))


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
