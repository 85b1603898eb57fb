"""Steps of a press that is to leave a top at a thickness."""

from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.control.thickness import CLOSE, LEAST_STEP, MOST_STEPS, next_step

WANTED, HAND, LOWEST = 0.030, 0.025, 0.010

heights = st.floats(0.0, 0.1)


@given(top=heights, wanted=heights, hand=heights, lowest=heights, limited=st.booleans(), steps=st.integers(0, 40))
def test_the_hand_goes_down_but_never_below_the_lowest_height(
    top: float, wanted: float, hand: float, lowest: float, limited: bool, steps: int
) -> None:
    step = next_step(top, wanted, hand, lowest, limited=limited, steps=steps)
    if step.ended:
        assert step.height == hand, "what ended stays where it is"
    else:
        assert lowest <= step.height < hand


@given(share=st.floats(0.0, 1.0), over=st.floats(0.0, 0.01))
def test_the_thickness_is_come_to_from_above_whatever_share_of_the_way_the_membrane_takes(
    share: float, over: float
) -> None:
    hand, top, steps = HAND, WANTED + over, 0
    while True:
        step = next_step(top, WANTED, hand, 0.0, limited=False, steps=steps)
        if step.ended:
            break
        top -= (1 - share) * (hand - step.height)
        hand, steps = step.height, steps + 1
    assert steps <= MOST_STEPS
    assert top >= WANTED - LEAST_STEP
    assert (step.ended == "thickness") == (top - WANTED <= CLOSE)
    if share < 0.5:
        assert step.ended == "thickness"
