"""How far an object has given way, from the curve through all presses."""

import numpy as np
import pytest

from stretch_bt.errors import IllConditioned, InvalidInput
from stretch_bt.model import fit_yielding


def readings(power, drop=1.5e-3, top=0.06, count=8, noise=0.0, seed=0):
    force = np.geomspace(0.05, 2.0, count)
    height = top - drop * (force / force[-1]) ** power
    return force, height + noise * np.random.default_rng(seed).standard_normal(count), np.full(count, max(noise, 1e-6))


@pytest.mark.parametrize("power", [0.6, 0.8, 1.0])
def test_an_exact_curve_is_found(power):
    found = fit_yielding(*readings(power))
    assert found.power == pytest.approx(power, abs=0.03)
    assert found.drop.value == pytest.approx(1.5e-3, rel=0.02)
    assert found.top.value == pytest.approx(0.06, abs=0.03e-3)
    assert found.height.value == pytest.approx(0.0585, abs=0.03e-3)


@pytest.mark.parametrize("power", [0.65, 1.0])
def test_errors_are_as_large_as_stated(power):
    off = []
    for seed in range(200):
        found = fit_yielding(*readings(power, noise=5e-5, seed=seed))
        off.append((found.drop.value - 1.5e-3) / found.drop.sd)
    assert 0.5 < np.sqrt(np.mean(np.square(off))) < 1.3


def test_scatter_beyond_the_stated_deviations_widens_the_answer():
    force, height, sd = readings(1.0, noise=1e-4)
    assert fit_yielding(force, height, 0.1 * sd).drop.sd > 0.5 * fit_yielding(force, height, sd).drop.sd


def test_a_rigid_object_gives_no_way():
    found = fit_yielding([0.1, 0.5, 1.0], [0.06, 0.06, 0.06], [1e-5] * 3)
    assert abs(found.drop.value) < found.drop.sd < 1e-4


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        (([1.0], [0.06], [1e-5]), IllConditioned, "one force"),
        (([1.0, 1.0], [0.06, 0.06], [1e-5, 1e-5]), IllConditioned, "one force"),
        (([1.0, 2.0], [0.06], [1e-5]), InvalidInput, r"\(n,\)"),
        (([0.0, 2.0], [0.06, 0.06], [1e-5, 1e-5]), InvalidInput, "above 0 N"),
        (([1.0, 2.0], [0.06, np.nan], [1e-5, 1e-5]), InvalidInput, "finite"),
        (([1.0, 2.0], [0.06, 0.06], [0.0, 1e-5]), InvalidInput, "above 0 m"),
    ],
)
def test_readings_without_an_answer_are_refused(given, error, said):
    with pytest.raises(error, match=said):
        fit_yielding(*given)
