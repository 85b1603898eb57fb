import numpy as np
import pytest

from stretch_bt.perception.shapes.pressed_surface import COMMON, CONE, FACE, SPHERE, PressedSurface

RATIO = 2.5  # of the tensions along y and x
LENGTH = 0.06  # over which the sheet bends


def surface(kind, *, scale=1.0, bent=0.0, curvature=0.5, lift=0.0):
    q = np.array(
        [0.1, 0.02, -0.03, curvature * scale, np.log(0.5), np.log(0.3), 0.05, 0.02, 0.5 * np.log(RATIO), *6 * [bent]]
    )
    edge = {FACE: [0.3 * scale, 0.02 * scale, 0.02], SPHERE: [lift, LENGTH]}.get(kind, [])
    return PressedSurface(kind, np.concatenate([q, edge]))


@pytest.mark.parametrize("kind", [SPHERE, FACE, CONE])
def test_the_skirt_goes_on_from_the_rim_with_its_height_and_slope(kind):
    curvature = 0.0 if kind == FACE else 0.5  # the edge's width rounds what a face's own curvature hands on as well
    pressed, turn, step = surface(kind, curvature=curvature), np.linspace(0.0, 6.0, 9), 1e-4
    heights = [
        pressed.heights(0.05 + share * 0.5 * np.cos(turn), 0.02 + share * 0.3 * np.sin(turn))
        for share in (1 - 2 * step, 1 - step, 1 + step, 1 + 2 * step)
    ]
    inner, across, outer = np.diff(heights, axis=0)
    np.testing.assert_allclose(across, 0.0, atol=1e-3)  # but for harmonics above the continued ones
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
    pressed, step = surface(kind, bent=0.05, lift=0.7), 1e-6
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


def test_around_a_ball_a_sheet_bends_by_the_plate_equation():
    """From a bending length before the rim the curvature goes from the ball's to the skirt's, as 1 - exp(-t)."""
    from scipy.integrate import solve_ivp

    curvature, rim, lift = 0.8, 0.5, 0.7
    q = np.array([0.0, 0.0, 0.0, curvature, *2 * [np.log(rim)], *9 * [0.0]])
    r = np.linspace(0.3, 0.9, 25)
    flat, bent = (PressedSurface(SPHERE, np.append(q, [share, LENGTH])).heights(r, 0.0 * r) for share in (0.0, lift))
    np.testing.assert_array_equal(flat, PressedSurface(SPHERE, q).heights(r, 0.0 * r))

    def bending(x, state):
        t = (x - rim) / LENGTH + 1.0
        return [state[1], 2.0 * curvature * lift * (float(t < 1.0) - np.exp(-t)) if t > 0.0 else 0.0]

    solved = solve_ivp(bending, (0.3, 0.9), [0.0, 0.0], t_eval=r, max_step=1e-3, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(bent - flat, solved.y[0], atol=2e-6)
