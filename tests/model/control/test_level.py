"""Keeping the force on what rolls under the hand."""

from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.control.level import MOST_STEP, ForceKeeper

START, LOWEST, WANTED = 0.030, 0.026, 1.0


@given(felt=st.lists(st.floats(0.0, 20.0), max_size=30), wanted=st.floats(0.01, 5.0))
def test_it_never_goes_below_the_lowest_height(felt: list[float], wanted: float) -> None:
    keeper = ForceKeeper(START)
    for force in felt:
        before = keeper.height
        keeper.keep(wanted, force, LOWEST)
        assert keeper.height >= LOWEST
        assert abs(keeper.height - before) <= MOST_STEP + 1e-12
