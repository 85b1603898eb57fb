import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.balloons.balance import Balance
from stretch_bt.simulation.balloons.cap import HAND, PLATE, Cap
from stretch_bt.simulation.balloons.elements import volume
from stretch_bt.simulation.balloons.filling import Gas, Liquid
from stretch_bt.simulation.balloons.fills import cap_volume

RADIUS, PRESSURE = 0.030, 3983.0
BELOW = cap_volume(RADIUS)
FILLS = {
    "constant pressure": Gas(1.0),
    "isothermal": Gas(BELOW),
    "adiabatic": Gas(BELOW, 1.4),
    "liquid": Liquid(),
}


def test_the_inflated_cap_is_the_sphere_of_laplace():
    """Without a hand it keeps the sphere that its tension holds against the pressure, up to the error of the mesh."""
    away, wrong = [], []
    for elements in (24, 48, 96):
        free = Cap(RADIUS, PRESSURE, elements=elements).free
        away.append(np.abs(np.hypot(*free.nodes.T) / RADIUS - 1).max())
        wrong.append(abs(free.pressure / PRESSURE - 1))
    assert away[2] < 2e-4
    assert all(a / b > 3.3 for a, b in pairwise(away))
    assert [a / b for a, b in pairwise(wrong)] == pytest.approx([4, 4], rel=0.02)


@pytest.mark.parametrize("fill", FILLS)
def test_the_equations_are_their_own_derivative(fill):
    cap = Cap(RADIUS, PRESSURE, filling=FILLS[fill], elements=10)
    state = cap.press(2e-3)
    balance = Balance(cap, 2e-3)
    noise = 1 + 1e-3 * np.random.default_rng(0).standard_normal(balance.size)
    unknown = balance.packed(state.nodes, state.pressure, state.hand) * noise
    matrix = balance.system(unknown)[1]
    moving = [k for k in range(balance.size) if k not in balance._fixed]
    for k in moving:
        step = np.zeros(balance.size)
        step[k] = 1e-7 * max(abs(unknown[k]), 1e-3)
        change = (balance.system(unknown + step)[0] - balance.system(unknown - step)[0]) / (2 * step[k])
        assert_allclose(change[moving], matrix[moving, k], rtol=1e-6, atol=1e-7 * np.abs(matrix[moving, k]).max())


@pytest.mark.parametrize("hand", [HAND, PLATE])
def test_energy_force_and_slope_belong_together(hand):
    """What skin and foundation store is the work of the hand, as a liquid stores none."""
    cap, step = Cap(RADIUS, PRESSURE, hand=hand), 2e-6
    middle = cap.press(2e-3)
    low, high = cap.press(2e-3 - step, middle), cap.press(2e-3 + step, middle)
    assert high.energy - low.energy == pytest.approx((low.hand - high.hand) * middle.force, rel=1e-5)
    assert (high.force - low.force) / (2 * step) == pytest.approx(middle.stiffness, rel=1e-4)


@pytest.mark.parametrize("fill", FILLS)
def test_the_fill_takes_the_room_that_its_law_says(fill):
    cap = Cap(RADIUS, PRESSURE, filling=FILLS[fill], elements=24)
    state = cap.press(3e-3)
    room = float(volume(state.nodes).value.sum())
    if fill == "liquid":
        assert room == pytest.approx(cap.volume, rel=1e-9)
        assert state.pressure > PRESSURE
    else:
        gas = FILLS[fill]
        before, after = ((v + gas.below) ** gas.exponent for v in (cap.volume, room))
        assert (101_325 + state.pressure) * after == pytest.approx((101_325 + cap.free.pressure) * before, rel=1e-9)
        assert fill != "constant pressure" or state.pressure == pytest.approx(PRESSURE, rel=1e-3)


@pytest.mark.parametrize(
    ("fill", "forces"),
    [
        ("constant pressure", (0.03, 0.10, 0.20)),
        ("isothermal", (0.39, 1.10, 2.22)),
        ("adiabatic", (0.39, 1.12, 2.27)),
        ("liquid", (0.41, 1.17, 2.40)),
    ],
)
def test_under_a_plate_it_agrees_with_an_independent_solver(fill, forces):
    """Forces at 2, 4 and 6 mm of one with 24 rings and derivatives by differences, to two digits."""
    cap, state = Cap(RADIUS, PRESSURE, filling=FILLS[fill], hand=PLATE), None
    for drop, force in zip((2e-3, 4e-3, 6e-3), forces, strict=True):
        state = cap.press(drop, state)
        assert state.force == pytest.approx(force, rel=0.05, abs=0.005)


@pytest.mark.parametrize(("drop", "error"), [(1.5e-3, 0.005), (3e-3, 0.004), (4e-3, 0.004)])
def test_the_error_falls_with_the_square_of_the_element(drop, error):
    f24, f48, f96, f192 = (Cap(RADIUS, PRESSURE, elements=n).press(drop).force for n in (24, 48, 96, 192))
    right = f192 + (f192 - f96) / 3
    assert abs(f48 / right - 1) < error
    assert abs(f96 - right) < 0.4 * abs(f48 - right)
    assert abs(f192 - right) < 0.35 * abs(f96 - right)
    assert abs(f24 / right - 1) < 0.015


def test_the_way_to_a_drop_does_not_matter():
    cap = Cap(RADIUS, PRESSURE)
    straight = cap.press(2e-3)
    there_and_back = cap.press(2e-3, cap.press(4e-3))
    assert there_and_back.force == pytest.approx(straight.force, rel=1e-7)


def test_size_and_pressure_scale():
    """In its own units a cap has only the hand's modulus times radius over pressure."""
    one, other = Cap(RADIUS, PRESSURE), Cap(1.0, 1.0, hand=HAND * RADIUS / PRESSURE)
    assert one.press(0.05 * RADIUS).force / (PRESSURE * RADIUS**2) == pytest.approx(other.press(0.05).force, rel=1e-8)


def test_no_drop_no_force():
    state = Cap(RADIUS, PRESSURE).press(0.0)
    assert (state.force, state.stiffness, state.contact_radius) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"radius": 0.0},
        {"pressure": -1.0},
        {"pressure": math.nan},
        {"hand": math.inf},
        {"prestretch": 1.0},
        {"elements": 3},
    ],
)
def test_what_is_no_cap_is_refused(wrong):
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        Cap(**{"radius": RADIUS, "pressure": PRESSURE, **wrong})


@pytest.mark.parametrize("drop", [-1e-3, RADIUS, math.nan])
def test_a_drop_is_from_0_to_the_height(drop):
    with pytest.raises(InvalidInput, match="drop"):
        Cap(RADIUS, PRESSURE).press(drop)


def test_a_drop_without_equilibrium_is_refused():
    with pytest.raises(NoEquilibrium, match="mm"):
        Cap(RADIUS, PRESSURE, elements=24).press(0.9 * RADIUS)
