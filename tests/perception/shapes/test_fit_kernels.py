import numpy as np
import pytest
from scipy.linalg import cholesky, solve_triangular

from stretch_bt.perception.shapes.blocks_kernel import squares_of
from stretch_bt.perception.shapes.contact_cells import Cells
from stretch_bt.perception.shapes.contact_noise import NoiseParts, whitener
from stretch_bt.perception.shapes.contact_noise_kernel import half_square
from stretch_bt.perception.shapes.fit_steps_kernel import damped_step, fill_left, fill_left_jacobian
from stretch_bt.perception.shapes.pressed_kernel import HARMONICS, rim_of, top_at
from stretch_bt.perception.shapes.pressed_surface import CONE, FACE, SPHERE, PressedSurface


def body(kind, rng):
    q = np.concatenate([rng.normal(0, 0.1, 3), [0.6], np.log(rng.uniform(0.2, 0.9, 2)), rng.normal(0, 0.1, 2), [0.5]])
    edge = [0.3, 0.1, 0.03] if kind == FACE else []
    return PressedSurface(kind, np.concatenate([q, rng.normal(0, 0.1, 6), edge]))


def skirt(kind, q, x, y):
    """Return the height of the skirt at one place outside the rim, as pressed_surface.py says it."""
    a, b, k = np.exp(q[4]), np.exp(q[5]), np.exp(q[8])
    harmonics = np.empty((4, HARMONICS))
    h0, p, s, fall, slope = rim_of(kind, q, harmonics)
    size, flat = (a + b / k) / 2, (a - b / k) / (a + b / k)
    w = complex(x - q[6], (y - q[7]) / k) / size
    root = np.sqrt(w * w - 4 * flat)
    z = (w + (root if (w * root.conjugate()).real >= 0 else -root)) / 2
    tau, turn = np.log(max(abs(z), 1.0)), z / abs(z)
    width = abs(q[17]) / size if kind == FACE else 0.0
    rounded = tau - width / 2 if tau >= width else tau**2 / (2 * width)
    sine = np.sin(np.arctan(slope))
    catenoid = np.arccosh(np.exp(rounded) / sine) - np.arccosh(1 / sine)
    height = h0 + p * (x - q[6]) + s * (y - q[7]) + harmonics[0, 0] - fall * np.cos(np.arctan(slope)) * catenoid
    for n in range(1, HARMONICS):
        value, across = complex(*harmonics[:2, n]), complex(*harmonics[2:, n])
        on = np.cosh(n * tau) * value + np.sinh(n * tau) / n * across if n < 3 else 0.0
        faded = np.exp(-n * tau) * ((1 + n * tau) * value + tau * across) if n >= 3 else 0.0
        height += 2 * (turn**n * (on + faded)).real
    if kind == FACE:
        height -= q[16] * np.sinh(2 * tau) / 2 * (turn**2).real * rounded / tau
    bends = [1.0, (turn**2).real, (turn**2).imag, turn.real, turn.imag, tau]
    return height + fall * tau**2 * (q[9:15] @ bends)


@pytest.mark.parametrize("kind", [SPHERE, FACE, CONE])
@pytest.mark.parametrize("seed", range(3))
def test_heights_are_those_of_the_formulas(kind, seed):
    rng = np.random.default_rng(seed)
    pressed, (x, y) = body(kind, rng), rng.uniform(-1, 1, (2, 60))
    q = pressed.q
    inside = ((x - q[6]) / np.exp(q[4])) ** 2 + ((y - q[7]) / np.exp(q[5])) ** 2 <= 1
    wanted = [top_at(kind, q, *at)[0] if on else skirt(kind, q, *at) for *at, on in zip(x, y, inside, strict=True)]
    assert 0 < inside.sum() < inside.size
    np.testing.assert_allclose(pressed.heights(x, y), wanted, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("kind", [SPHERE, FACE, CONE])
def test_what_is_left_is_taken_where_the_rays_come_down(kind):
    rng = np.random.default_rng(1)
    pressed, (x, y, z, before), lean = body(kind, rng), rng.uniform(-0.8, 0.8, (4, 50)), rng.normal(0, 0.2, (2, 50))
    at, left, jacobian = (x - lean[0] * before, y - lean[1] * before), np.empty(50), np.empty((pressed.q.size, 50))
    fill_left(kind, pressed.q, x, y, z, lean, before, left)
    np.testing.assert_array_equal(left, z - pressed.heights(*at))
    fill_left_jacobian(kind, pressed.q, x, y, lean, before, jacobian)
    np.testing.assert_array_equal(jacobian, pressed.derivatives(*at)[1])


@pytest.mark.parametrize(("scale", "share"), [(1e-3, 1.0), (10.0, None)])
def test_a_step_solves_the_damped_equations_and_is_shortened(scale, share):
    rng = np.random.default_rng(2)
    half, slope, q, moved = rng.normal(size=(40, 15)), scale * rng.normal(size=15), rng.normal(size=15), np.empty(15)
    normal = half.T @ half
    assert damped_step(q, normal, slope, 0.1, moved)
    step = np.linalg.solve(normal + 0.1 * np.diag(np.diag(normal)), slope)
    share = share or 1 / np.max(np.abs(step[4:9]) / [0.4, 0.4, 0.4, 0.4, 0.5])
    np.testing.assert_allclose(moved - q, share * step, rtol=1e-9, atol=1e-12)


def test_a_step_is_refused_where_the_equations_have_no_solution():
    assert not damped_step(np.zeros(15), np.zeros((15, 15)), np.ones(15), 0.1, np.empty(15))
    assert not damped_step(np.zeros(15), np.full((15, 15), np.nan), np.ones(15), 0.1, np.empty(15))


def cells(count, rng):
    x, y, z, u, v = rng.uniform(0, 1, (5, count)) * [[1], [1], [1], [90], [90]]
    return Cells(x, y, z, np.zeros((2, count)), u, v, rng.integers(1, 30, count).astype(float), np.zeros(3), 0.02)


def test_whitened_errors_are_those_of_the_covariance():
    rng, noise = np.random.default_rng(3), NoiseParts(1e-8, ((2e-8, 2.0), (1e-8, 4.5)))
    some, errors = cells(60, rng), rng.normal(size=(60, 7))
    apart = (some.u[:, None] - some.u) ** 2 + (some.v[:, None] - some.v) ** 2
    spreads = [s**2 + np.add.outer(some.count, some.count) / 24 for _, s in noise.smooth]
    parts = [v * s**2 / w * np.exp(-apart / 4 / w) for (v, s), w in zip(noise.smooth, spreads, strict=True)]
    covariance = sum(parts) / some.size**2 + np.diag(noise.own(some, 0.1))
    whiten = whitener(noise.own(some, 0.1), noise.shared(some))
    wanted = solve_triangular(cholesky(covariance, lower=True), errors, lower=True)
    np.testing.assert_allclose(whiten(errors), wanted, rtol=1e-9)
    np.testing.assert_allclose(whiten(errors[:, 0]), wanted[:, 0], rtol=1e-9)


@pytest.mark.parametrize("lag", [1, 4])
def test_half_squares_are_those_of_all_pairs_over_a_lag(lag):
    rng = np.random.default_rng(4)
    left = np.where(rng.random((30, 25)) < 0.2, np.nan, rng.normal(size=(30, 25)))
    apart = np.concatenate([(left[lag:] - left[:-lag]).ravel(), (left[:, lag:] - left[:, :-lag]).ravel()])
    kept = apart[np.abs(apart) <= 2.0]
    assert half_square(left, lag, 2.0) == pytest.approx(0.5 * np.mean(kept**2), rel=1e-12)
    assert half_square(np.full((30, 25), np.nan), lag, 2.0) == 0.0


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_squares_hold_the_means_of_what_is_seen(dtype):
    surface = np.random.default_rng(5).normal(size=(23, 31, 3)).astype(dtype)
    surface[3:9, 5:20] = np.nan
    found = squares_of(surface, 7)
    assert found.shape == (3, 4, 4)
    for v, u in np.ndindex(3, 4):
        square = surface[7 * v : 7 * v + 7, 7 * u : 7 * u + 7].reshape(-1, 3).astype(float)
        seen = square[np.isfinite(square[:, 2])]
        assert found[v, u, 3] == len(seen)
        np.testing.assert_allclose(found[v, u, :3], seen.mean(axis=0) if len(seen) else 0.0, rtol=1e-12)
