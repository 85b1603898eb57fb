import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.perception import RIMS
from stretch_bt.perception.size import conformal
from stretch_bt.perception.size.conformal import COUNT, KINK, Rim, skirt


def around(rim, tau):
    """Return places (n,) on a curve of constant tau around a rim."""
    psi = np.linspace(0.1, 2 * np.pi, 40)
    a, b = rim.half_i, rim.half_j / rim.k
    s, m = (a + b) / 2, (a - b) / (a + b)
    zeta = np.exp(tau + 1j * psi)
    w = s * (zeta + m / zeta)
    return rim.x + w.real, rim.y + rim.k * w.imag


@given(RIMS)
@settings(max_examples=30)
def test_the_skirt_balances_the_two_tensions_and_leaves_from_the_rim(rim):
    coefficients = np.array([4e-3, 1e-3, -1e-3, 2e-3, 1e-3, 0.0, 0.0])
    x, y = around(rim, 0.6)
    h = 2e-5
    middle, west, east, south, north = (
        skirt(rim, coefficients, x + u, y + v)[0] for u, v in ((0, 0), (-h, 0), (h, 0), (0, -h), (0, h))
    )
    across, along = (east - 2 * middle + west) / h**2, (north - 2 * middle + south) / h**2
    assert np.abs(across + rim.k**2 * along).max() < 1e-3 * np.abs(across).max()
    fall, _, _, outside = skirt(rim, coefficients, *around(rim, 0.0))
    assert np.abs(outside).max() < 1e-9
    assert np.abs(fall).max() < 10e-3 * KINK / min(rim.half_i, rim.half_j) * rim.k * 3


@given(RIMS, st.integers(0, 2**31))
@settings(max_examples=30)
def test_derivatives_are_those_of_the_fall(rim, seed):
    rng = np.random.default_rng(seed)
    coefficients = rng.normal(0.0, 3e-3, COUNT)
    x, y = around(rim, 0.7)
    _, by_rim, basis, _ = skirt(rim, coefficients, x, y)
    for place, (name, step) in enumerate(
        [("x", 1e-6), ("y", 1e-6), ("half_i", 1e-6), ("half_j", 1e-6), ("log_ratio", 1e-5)]
    ):
        fields = {f: getattr(rim, f) for f in ("x", "y", "half_i", "half_j", "log_ratio")}
        up, down = (skirt(Rim(**{**fields, name: fields[name] + s}), coefficients, x, y)[0] for s in (step, -step))
        numeric = (up - down) / (2 * step)
        assert by_rim[place] == pytest.approx(numeric, rel=1e-4, abs=1e-4 * np.abs(numeric).max())
    assert coefficients @ basis == pytest.approx(skirt(rim, coefficients, x, y)[0])


def test_slopes_are_those_beside_the_rim(monkeypatch):
    monkeypatch.setattr(conformal, "KINK", 1e-10)
    rim = Rim(0.0, 0.0, 9e-3, 7e-3, 2.0)
    coefficients = np.array([4e-3, 1e-3, -1e-3, 1e-3, 1e-3, 0.5e-3, 0.5e-3])
    out = np.array([1e-7, 2e-7])
    found = []
    for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        fall = skirt(rim, coefficients, x * (9e-3 + out), y * (7e-3 + out))[0]
        found.append(np.diff(fall)[0] / 1e-7)
    assert rim.slopes(coefficients) == pytest.approx([np.mean(found[:2]), np.mean(found[2:])], rel=1e-3)
