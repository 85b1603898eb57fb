import numpy as np
import pytest

from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, SPHERE, PressedSurface

RATIO = 2.5  # of the tensions along y and x


def surface(kind, *, scale=1.0, bent=0.0, curvature=0.5):
    q = np.array(
        [0.1, 0.02, -0.03, curvature * scale, np.log(0.5), np.log(0.3), 0.05, 0.02, 0.5 * np.log(RATIO), *6 * [bent]]
    )
    return PressedSurface(kind, np.concatenate([q, [0.3 * scale, 0.02 * scale, 0.02]]) if kind == FACE else q)


@pytest.mark.parametrize("kind", [SPHERE, FACE, CONE])
def test_the_skirt_goes_on_from_the_rim_with_its_height_and_slope(kind):
    curvature = 0.0 if kind == FACE else 0.5  # the edge's width rounds what a face's own curvature hands on as well
    pressed, turn, step = surface(kind, curvature=curvature), np.linspace(0.0, 6.0, 9), 1e-4
    heights = [
        pressed.heights(0.05 + share * 0.5 * np.cos(turn), 0.02 + share * 0.3 * np.sin(turn))
        for share in (1 - 2 * step, 1 - step, 1 + step, 1 + 2 * step)
    ]
    inner, across, outer = np.diff(heights, axis=0)
    np.testing.assert_allclose(across, 0.0, atol=1e-3)  # but for harmonics beyond those that are continued
    np.testing.assert_allclose(inner / step, outer / step, atol=4e-3 if kind == SPHERE else 0.03)


@pytest.mark.parametrize("kind", [SPHERE, FACE])
def test_a_shallow_skirt_is_in_equilibrium(kind):
    pressed, step = surface(kind, scale=1e-3), 1e-3
    x, y = 0.05 + np.array([0.7, -0.5, 0.1, 0.6]), 0.02 + np.array([0.1, 0.3, 0.5, -0.4])
    middle = pressed.heights(x, y)
    xx = pressed.heights(x + step, y) + pressed.heights(x - step, y) - 2 * middle
    yy = pressed.heights(x, y + step) + pressed.heights(x, y - step) - 2 * middle
    assert np.abs(xx + RATIO * yy).max() < 2e-2 * np.abs(xx).max()


@pytest.mark.parametrize("kind", [SPHERE, FACE, CONE])
def test_derivatives_are_those_of_the_heights(kind):
    pressed, step = surface(kind, bent=0.05), 1e-6
    x, y = np.random.default_rng(0).uniform(-0.8, 0.8, (2, 40))
    _, jacobian = pressed.derivatives(x, y)
    for p in range(pressed.q.size):
        up, down = (
            PressedSurface(kind, pressed.q + s * np.eye(pressed.q.size)[p]).heights(x, y) for s in (step, -step)
        )
        np.testing.assert_allclose(jacobian[p], (up - down) / (2 * step), atol=2e-3)


def test_a_steep_round_skirt_is_a_catenoid():
    q = np.zeros(COMMON)
    q[3], q[4:6] = 1.0, np.log(0.7)  # leaves a sphere of radius 1 at asin(0.7)
    r = np.linspace(0.7, 1.5, 9)
    fall = 0.49 * (np.arccosh(r / 0.49) - np.arccosh(0.7 / 0.49))
    np.testing.assert_allclose(PressedSurface(SPHERE, q).heights(r, 0.0 * r), np.sqrt(0.51) - 1.0 - fall, atol=1e-6)
