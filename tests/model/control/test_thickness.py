"""Steps of a press that is to leave a top at a thickness."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.control.thickness import CLOSE, LEAST_STEP, MOST_STEPS, Step, next_step

WANTED, HAND, LOWEST = 0.030, 0.025, 0.010

heights = st.floats(0.0, 0.1)


@pytest.mark.parametrize(
    ("over", "limited", "steps", "hand", "step"),
    [
        (CLOSE - 1e-9, False, 1, HAND, Step(HAND, "thickness")),
        (-0.002, False, 1, HAND, Step(HAND, "thickness")),
        (0.0, True, MOST_STEPS, LOWEST, Step(LOWEST, "thickness")),  # however it came there
        (0.004, True, 1, HAND, Step(HAND, "force")),
        (0.004, True, MOST_STEPS, LOWEST, Step(LOWEST, "force")),
        (0.004, False, 1, LOWEST, Step(LOWEST, "depth")),
        (0.004, False, MOST_STEPS, HAND, Step(HAND, "depth")),
        (0.004, False, MOST_STEPS - 1, HAND, Step(HAND - 0.004)),
        (0.040, False, 1, HAND, Step(LOWEST)),
    ],
)
def test_what_comes_next(over: float, limited: bool, steps: int, hand: float, step: Step) -> None:
    found = next_step(WANTED + over, WANTED, hand, LOWEST, limited=limited, steps=steps)
    assert found.ended == step.ended
    assert found.height == pytest.approx(step.height)


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
