"""A membrane that something pulls down, against how it hung freely."""

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned, InvalidInput, NoContact
from stretch_bt.frames import DepthFrame, Intrinsics
from stretch_bt.perception import FreeView, pulled_down, without_pattern
from stretch_bt.perception.smooth import smooth
from stretch_bt.units import Estimate

LENS = Intrinsics(475.0, 475.0, 100.0, 110.0, 200, 220)
DISTANCE, UNIT, NOISE, HANG = 0.2, 1.25e-4, 1e-4, Estimate(0.6e-3, 0.1e-3)
ALONG = (np.arange(220) - LENS.cy)[:, None] / LENS.fy * DISTANCE
ACROSS = (np.arange(200) - LENS.cx)[None, :] / LENS.fx * DISTANCE
FREE = DISTANCE + HANG.value * (1 - (2 * ALONG / 0.1) ** 2) + 0 * ACROSS


def frames(depth, rng, count=8):
    """Return the mean of frames of a depth image."""
    seen = depth + rng.normal(0.0, NOISE / np.sqrt(count), depth.shape)
    return DepthFrame(np.rint(seen / UNIT * 8).astype(np.uint16), UNIT / 8, LENS, 0.0, 0, DISTANCE, stretch=0.0)


@pytest.fixture(params=[0, 1, 2])
def view(request):
    """Return the noise, the camera's static error, and the pattern that the free membrane teaches of it."""
    rng = np.random.default_rng(request.param)
    field, _ = smooth(rng.standard_normal(FREE.shape).astype(np.float32), np.ones(FREE.shape, np.float32), 20.0)
    error, view = 4e-4 * field / field.std(), FreeView()
    for number in range(60):
        seen = np.rint((FREE + error + rng.normal(0, NOISE, FREE.shape)) / UNIT).astype(np.uint16)
        view.add(DepthFrame(seen, UNIT, LENS, number / 30, number, DISTANCE, stretch=0.0))
    return rng, error, view.pattern(0.1, HANG)


def dimple(depth, x=0.0, y=0.0):
    """Return a funnel that falls to its flat bottom, 16 mm wide, as a logarithm of the distance."""
    distance = np.hypot(ALONG - y, ACROSS - x)
    return depth * np.clip(np.log(0.045 / np.maximum(distance, 0.008)) / np.log(0.045 / 0.008), 0, None)


@pytest.mark.parametrize("depth", [0.0, 0.5e-3, 1e-3, 3e-3])
@pytest.mark.parametrize("at", [(0.0, 0.0), (0.015, -0.02)])
def test_it_tells_how_far_a_place_is_pulled_wherever_it_is(view, depth, at):
    rng, error, pattern = view
    found = pulled_down(without_pattern(frames(FREE + error + dimple(depth, *at), rng), pattern), pattern)
    assert found.value == pytest.approx(depth, abs=0.15 * depth + 0.1e-3)
    assert found.sd < 0.1e-3 + 0.05 * depth
    assert (found.value > max(0.4e-3, 3 * found.sd)) == (depth > 0)


def test_what_pushes_it_up_does_not_pull(view):
    rng, error, pattern = view
    found = pulled_down(without_pattern(frames(FREE + error - dimple(2e-3), rng), pattern), pattern)
    assert found.value < 0.1e-3


@pytest.mark.parametrize("fault", ["nothing is seen", "another shape", "another stretch", "no distance"])
def test_what_cannot_be_compared_is_refused(view, fault):
    rng, _, pattern = view
    frame = frames(FREE, rng)
    raw, lens, distance, stretch = frame.raw, LENS, DISTANCE, 0.0
    if fault == "nothing is seen":
        raw = 0 * raw
    elif fault == "another shape":
        raw, lens = raw[:-1], Intrinsics(475.0, 475.0, 100.0, 110.0, 200, 219)
    elif fault == "another stretch":
        stretch = 0.01
    else:
        distance = None
    error = NoContact if fault == "nothing is seen" else InvalidInput
    with pytest.raises(error):
        pulled_down(DepthFrame(raw, UNIT, lens, 0.0, 0, distance, stretch=stretch), pattern)


@pytest.mark.parametrize("rows", [40, 56])
def test_a_strip_too_narrow_to_tell_noise_by_is_refused(rows):
    lens, view = Intrinsics(475.0, 475.0, 100.0, rows / 2, 200, rows), FreeView()
    shots = [DepthFrame(np.full((rows, 200), 1600, np.uint16), UNIT, lens, k / 30, k, DISTANCE) for k in range(30)]
    for shot in shots:
        view.add(shot)
    view.settle()
    with pytest.raises(IllConditioned, match="too little of the membrane"):
        pulled_down(shots[0], view.pattern(0.1, HANG))
