from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.balloons import HANDS, SOFTNESS
from stretch_bt.simulation.balloons.table import read_table


@settings(max_examples=60)
@given(kappa=HANDS, drop=st.floats(1e-4, 0.95), beta=SOFTNESS)
def test_force_rises_with_the_drop_and_with_the_hand_that_spreads_it(kappa, drop, beta):
    cap = read_table().at(kappa)
    force, slope = cap.force(drop)
    s, by = cap.yields(drop)
    assert force > 0
    assert slope > 0
    assert slope * (1 + beta * s) > force * beta * by  # a gas under a rising drop pushes harder
    assert cap.flattening(drop)[1] >= -0.05  # the contact of the solver behind the table advances node by node
    assert 0 < cap.limit < 0.5
