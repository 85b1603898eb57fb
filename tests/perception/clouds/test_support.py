"""Which of a membrane that stays lies on something, by how it bends."""

import numpy as np
import pytest
from scipy.ndimage import binary_erosion

from stretch_bt.perception.clouds.expected import TENSIONS, drape
from stretch_bt.perception.clouds.support import supported

MM = 1e-3
X, Y = np.meshgrid(np.arange(-30.0, 30.0) + 0.5, np.arange(-40.0, 40.0) + 0.5, indexing="ij")  # mm
WITHIN = np.hypot(X, Y) < 18.0


def told(heights, stays, turn=0.0, noise=0.0):
    rough = np.random.default_rng(0).normal(0.0, 1.0, heights.shape) * noise
    return supported(heights * MM + rough * MM, stays, turn=turn, cell=MM)


def saddle(rise, turn=0.0):
    """Return a free membrane that rises across its clamps by so much, mm, over 18 mm."""
    across, along = X * np.cos(turn) + Y * np.sin(turn), Y * np.cos(turn) - X * np.sin(turn)
    return rise * (across**2 - along**2 / TENSIONS) / 18.0**2


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_flat_part_lies_on_a_face(noise):
    lies, hangs = told(0.2 * X, WITHIN, noise=noise)
    assert lies[WITHIN].mean() > 0.95
    assert not hangs.any()


@pytest.mark.parametrize("turn", [0.0, 0.7, np.pi / 2])
def test_a_flat_part_that_is_a_saddle_as_a_whole_hangs(turn):
    lies, hangs = told(saddle(0.12, turn), WITHIN, turn, noise=0.01)
    assert not lies.any()
    assert hangs[WITHIN].mean() > 0.95


def hung(ground, level):
    """Return a sheet whose clamps are at a level, mm, over a ground, and where it touches, its rim aside."""
    sheet = drape(ground[None] * MM, np.array([level * MM]))[0] / MM
    return sheet, binary_erosion(sheet - ground < 0.01)


@pytest.mark.parametrize("radius", [12.0, 30.0])
def test_a_dome_is_felt(radius):
    sheet, touches = hung(10.0 - (X**2 + Y**2) / (2 * radius), 3.0)
    assert touches.sum() > 20
    assert told(sheet, touches)[0][touches].all()


@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
def test_a_cylinder_is_felt_along_and_across_the_hand(turn):
    across, along = X * np.cos(turn) + Y * np.sin(turn), Y * np.cos(turn) - X * np.sin(turn)
    sheet, touches = hung(np.where(np.abs(along) < 15.0, 10.0 - across**2 / 40.0, 0.0), 3.0)
    assert touches.sum() > 100
    assert told(sheet, touches)[0][touches].mean() > 0.95


@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
def test_a_cylinder_is_felt_up_to_where_the_camera_sees_no_more(turn):
    across = X * np.cos(turn) + Y * np.sin(turn)
    seen = across < 9.0
    lies, hangs = told(np.where(seen, 10.0 - across**2 / 40.0 - 0.3 * across, np.nan), seen, turn)
    assert lies[seen].mean() > 0.97
    assert not hangs.any()


def test_a_strong_saddle_hangs():
    lies, hangs = told(saddle(5.0), WITHIN)
    assert not lies.any()
    assert hangs[WITHIN].all()


def test_a_membrane_between_two_domes_hangs_and_their_tops_are_felt():
    ground = sum(9.0 * np.sqrt(np.maximum(1 - ((X - at) ** 2 + Y**2) / 81.0, 0.0)) for at in (-11.0, 11.0))
    sheet, touches = hung(ground, 1.0)
    lies, hangs = told(sheet, sheet > 1.5)
    middle = np.hypot(X, Y) < 1.5
    assert not lies[middle].any()
    assert hangs[middle].all()
    assert lies[touches & (np.hypot(np.abs(X) - 11.0, Y) < 3.0)].all()


def test_specks_are_noise_and_nothing_stays_nothing_lies():
    speck = np.hypot(X, Y) < 1.4
    assert not told(0.0 * X, speck)[0].any()
    assert not told(0.0 * X, np.zeros_like(speck))[0].any()
