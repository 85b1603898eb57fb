import numpy as np
import pytest
from hypothesis import given, settings

from stretch_bt.hardcases.strategies.perception import ANGLES, RATIOS, SIDES
from stretch_bt.perception.size.around import COUNT, ORDERS
from stretch_bt.perception.size.box_rim import BoxRim


@settings(max_examples=50)
@given(SIDES, SIDES, ANGLES, RATIOS)
def test_the_unit_circle_is_mapped_onto_the_sides_of_the_rectangle(first, second, rotation, ratio):
    rim = BoxRim(0.0, 0.0, first, second, rotation, ratio)
    w, _ = rim.map()(np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 400)))
    outside = rim.outside(w.real, rim.k * w.imag)
    corner = (
        np.abs(np.abs(rim.along_sides(w.real, rim.k * w.imag)) - 0.5 * np.array([[first], [second]])).max(axis=0)
        < 1.5e-3
    )
    assert np.abs(outside[~corner]).max() < 0.15e-3
    assert np.abs(outside).max() < 0.6e-3  # corners are rounded


@settings(max_examples=20)
@given(SIDES, SIDES, ANGLES, RATIOS)
def test_the_skirt_is_level_inside_and_obeys_the_tensions_outside(first, second, rotation, ratio):
    rim = BoxRim(1e-3, -2e-3, first, second, rotation, ratio)
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-30e-3, 30e-3, (2, 400))
    outside = rim.outside(x, y)
    c = np.where([kind == "sinh" for kind, _, _ in ORDERS], 1e-3, 0.0)
    deep, far = outside < -2e-3, (outside > 3e-3) & (outside < 12e-3)
    assert not rim.skirt(c, x[deep], y[deep])[0].any()
    step = 0.2e-3
    middle, *around = (
        rim.skirt(c, x[far] + i * step, y[far] + j * step)[0] for i, j in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
    )
    across, along = ((a + b - 2.0 * middle) / step**2 for a, b in (around[:2], around[2:]))
    assert np.abs(across + np.exp(ratio) * along).max() < 0.02 * (np.abs(across) + np.exp(ratio) * np.abs(along)).max()


def test_the_derivatives_of_the_skirt_are_those_of_its_height():
    rng = np.random.default_rng(1)
    at = np.array([1e-3, -2e-3, 22e-3, 12e-3, 0.6, 2.4])
    x, y = rng.uniform(-20e-3, 20e-3, (2, 2000))
    outside = BoxRim(*at).outside(x, y)
    u, v = BoxRim(*at).along_sides(x, y)
    corner = np.hypot(np.abs(u) - 11e-3, np.abs(v) - 6e-3) < 2e-3
    near = (outside > 0.0) & (outside < 12e-3) & ~corner
    c = rng.normal(0.0, 1e-3, COUNT)
    _, by_rim, basis = BoxRim(*at).skirt(c, x[near], y[near])
    for n, step in enumerate((1e-7, 1e-7, 1e-7, 1e-7, 1e-6, 1e-5)):
        move = step * np.eye(6)[n]
        plus, minus = (BoxRim(*(at + sign * move)).skirt(c, x[near], y[near])[0] for sign in (1, -1))
        numeric = (plus - minus) / (2.0 * step)
        assert np.quantile(np.abs(by_rim[n] - numeric), 0.99) < 5e-3 * np.abs(numeric).max()
    assert BoxRim(*at).skirt(c, x[near], y[near])[0] == pytest.approx(c @ basis, abs=1e-12)
