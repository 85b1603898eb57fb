"""The curve's derivatives, which readings are of one press, and the fit where the power stands at its bound."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.model import ForceModel, TopReading
from stretch_bt.model.force.local import local_forces
from stretch_bt.model.palpation.balance import Balance
from stretch_bt.units import Estimate

MODEL = ForceModel.default()
STIFFENING = Estimate(0.03, 0.06)
TOP = 0.06
DEPTHS = (0.002, 0.004, 0.007, 0.010, 0.010, 0.012)


def readings(stiffness, power, off):
    """Return readings of an object of so much force over drop at 1.5 mm, N/m, by bisection, each `off` by so much, m."""
    found = []
    for depth, error in zip(DEPTHS, off, strict=True):
        hand, low, high = TOP - depth, TOP - depth, TOP
        for _ in range(50):
            middle = (low + high) / 2
            more = MODEL.predict(0.03, 0.0, middle - hand)[0] > stiffness * 1.5e-3 * ((TOP - middle) / 1.5e-3) ** power
            low, high = (low, middle) if more else (middle, high)
        found.append(TopReading(0.0, hand, low + error, 3e-5))
    return found


def balance(given_, power, robot=5e-5):
    return Balance(local_forces(MODEL, 0.03, given_), given_, None, power, STIFFENING, robot)


@settings(max_examples=30, deadline=None)
@given(stiffness=st.floats(150.0, 3000.0), power=st.floats(0.8, 2.2), seed=st.integers(0, 99))
def test_the_derivatives_of_the_curve_are_those_of_its_values(stiffness, power, seed):
    noise = np.random.default_rng(seed)
    fit = balance(readings(stiffness, power, 3e-5 * noise.standard_normal(len(DEPTHS))), Estimate(1.4, 0.3))
    fit.solve()
    q = fit.q + np.r_[1e-5, 2e-5, 0.05, 0.02, 3e-5 * noise.standard_normal(len(fit.q) - 4)]
    _, rows = fit.curve(q)
    for k, step in enumerate(np.r_[1e-7, 1e-7, 1e-4, 1e-4, np.full(len(q) - 4, 1e-7)]):
        moved = np.eye(len(q))[k] * step
        slope = (fit.curve(q + moved)[0] - fit.curve(q - moved)[0]) / (2 * step)
        np.testing.assert_allclose(rows[:, k], slope, atol=1e-5 * max(1e-3, np.abs(slope).max()))
