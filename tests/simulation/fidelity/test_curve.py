"""Forces between presses: what is interpolated, how many presses it takes, and what happens where none can be solved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.fidelity.curve import Curve

_DEEPEST = 0.0085  # m


class Presses:
    """Counts the depths that are solved, by a law of depth past `-lift`."""

    def __init__(self, power: float, lift: float = 0.0, lean: float = 0.0) -> None:
        self.power, self.lift, self.lean = power, lift, lean
        self.solved: list[float] = []

    def __call__(self, depth: float) -> np.ndarray:
        self.solved.append(depth)
        if depth > _DEEPEST:
            raise NoEquilibrium("too deep")
        force = 50.0 * (depth + self.lift) ** self.power
        return np.array([0.0, self.lean * force, force])


@given(st.floats(1.0, 3.0), st.floats(0.1e-3, 8e-3), st.floats(0.0, 1e-3))
def test_a_power_of_the_travel_is_met_with_its_slope(power: float, depth: float, lift: float) -> None:
    presses = Presses(power, lift, lean=0.3)
    curve = Curve(presses, lift)
    force, slope = curve(depth)
    travel = depth + lift
    assert force == pytest.approx(50.0 * travel**power, rel=1e-9)
    assert slope == pytest.approx(power * force / travel, rel=1e-6)
    np.testing.assert_allclose(curve.force(depth), [0.0, 0.3 * force, force], rtol=1e-9)


def test_a_press_is_solved_once_for_all_depths_near_it() -> None:
    presses = Presses(2.0)
    curve = Curve(presses)
    for depth in np.linspace(2e-3, 6e-3, 100):
        curve(float(depth))
    assert len(presses.solved) == len(set(presses.solved)) <= 8


@pytest.mark.parametrize("depth", [8.2e-3, 8.49e-3])
def test_close_to_the_deepest_press_shallower_ones_serve(depth: float) -> None:
    presses = Presses(1.7)
    curve = Curve(presses)
    assert curve(depth)[0] == pytest.approx(50.0 * depth**1.7, rel=1e-9)
    tried = [d for d in presses.solved if d > _DEEPEST]
    curve(depth - 1e-5)
    assert [d for d in presses.solved if d > _DEEPEST] == tried


def test_past_the_deepest_press_there_is_no_force() -> None:
    with pytest.raises(NoEquilibrium, match="too deep"):
        Curve(Presses(2.0))(9.5e-3)


def test_what_does_not_touch_has_neither_force_nor_slope() -> None:
    curve = Curve(Presses(2.0, lift=1e-3), 1e-3)
    assert curve(-1.5e-3) == (0.0, 0.0)
    assert not curve.force(-1.5e-3).any()


def test_where_some_presses_miss_the_object_no_force_is_below_zero() -> None:
    curve = Curve(lambda depth: np.array([0.0, 0.0, max(0.0, 100.0 * (depth - 3.2e-3))]))
    assert [curve(d)[0] for d in (1e-3, 2e-3)] == [0.0, 0.0]
    assert all(curve(float(d))[0] >= 0.0 for d in np.linspace(1e-4, 8e-3, 200))
