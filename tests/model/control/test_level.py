"""Keeping the force on what rolls under the hand."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.control.level import LOST, MOST_STEP, PATIENCE, STIFFNESS, ForceKeeper

START, LOWEST, WANTED = 0.030, 0.026, 1.0


@pytest.mark.parametrize(
    ("felt", "height"),
    [
        (WANTED, START),
        (WANTED - 0.3, START - 0.3 / STIFFNESS),
        (WANTED + 0.3, START + 0.3 / STIFFNESS),
        (WANTED + 50.0, START + MOST_STEP),
    ],
)
def test_the_hand_goes_towards_the_wanted_force_by_no_more_than_a_step(felt: float, height: float) -> None:
    keeper = ForceKeeper(START)
    keeper.keep(WANTED, felt, LOWEST)
    assert keeper.height == pytest.approx(height)


@given(felt=st.lists(st.floats(0.0, 20.0), max_size=30), wanted=st.floats(0.01, 5.0))
def test_it_never_goes_below_the_lowest_height(felt: list[float], wanted: float) -> None:
    keeper = ForceKeeper(START)
    for force in felt:
        before = keeper.height
        keeper.keep(wanted, force, LOWEST)
        assert keeper.height >= LOWEST
        assert abs(keeper.height - before) <= MOST_STEP + 1e-12


@pytest.mark.parametrize("stiffness", [100.0, 300.0, 550.0])
def test_the_force_creeps_to_where_it_is_wanted(stiffness: float) -> None:
    keeper, touched = ForceKeeper(START), START
    for _ in range(100):
        keeper.keep(WANTED, stiffness * max(touched - keeper.height, 0.0), 0.0)
    assert stiffness * (touched - keeper.height) == pytest.approx(WANTED, rel=0.01)


NOTHING, LITTLE = 0.0, 2 * LOST * WANTED


@pytest.mark.parametrize(
    ("start", "felt", "lost"),
    [
        (LOWEST, [NOTHING] * PATIENCE, True),
        (LOWEST, [NOTHING] * (PATIENCE - 1), False),
        (LOWEST, [LITTLE] * 3 * PATIENCE, False),
        (LOWEST, ([NOTHING] * (PATIENCE - 1) + [LITTLE]) * 3, False),  # felt again within a lap
        (START, [NOTHING] * PATIENCE, False),  # on the way down nothing is missed yet
        (START, [NOTHING] * 2 * PATIENCE, True),
    ],
)
def test_it_is_lost_where_nothing_was_felt_for_a_lap_at_the_lowest_height(
    start: float, felt: list[float], lost: bool
) -> None:
    keeper = ForceKeeper(start)
    for force in felt:
        keeper.keep(WANTED, force, LOWEST)
    assert keeper.is_lost == lost
