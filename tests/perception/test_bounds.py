"""What a frame may cost and hold: bounds of work, of intrinsics and kinds of numbers, and reasons that say what to try."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import stretch_bt.perception
from stretch_bt.perception.smooth import gain, gaussian
from stretch_bt.perception.surface_kernel import fill_moves


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
