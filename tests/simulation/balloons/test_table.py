import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.balloons.cap import Cap
from stretch_bt.simulation.balloons.filling import Gas
from stretch_bt.simulation.balloons.fills import cap_volume
from stretch_bt.simulation.balloons.table import read_table


@pytest.mark.parametrize("kappa", [1.3, 1.95, 3.9, 11.0])
def test_between_its_rows_it_is_the_solver(kappa):
    cap = read_table().at(kappa)
    coarse, fine = (Cap(1.0, 1.0, hand=kappa, elements=n) for n in (96, 192))
    a = b = None
    for drop in np.array([0.15, 0.5, 0.9]) * cap.limit:
        a, b = coarse.press(float(drop), a), fine.press(float(drop), b)
        assert cap.force(float(drop))[0] == pytest.approx(b.force + (b.force - a.force) / 3, rel=0.003)


@pytest.mark.parametrize(("beta", "error"), [(0.02, 0.004), (0.08, 0.02)])
def test_a_gas_takes_off_what_the_table_says(beta, error):
    cap = read_table().at(2.0)
    gas = Gas(cap_volume(1.0), 1.0, 2 / beta - 1)
    for drop in (0.05, 0.12):
        liquid, soft = (
            Cap(1.0, 1.0, hand=2.0, filling=f, elements=96).press(drop).force for f in (Cap(1, 1).filling, gas)
        )
        assert liquid / (1 + beta * cap.yields(drop)[0]) == pytest.approx(soft, rel=error)
        assert soft < liquid


@settings(max_examples=60)
@given(kappa=st.floats(0.7, 300.0), drop=st.floats(1e-4, 0.95), beta=st.floats(0.0, 0.2))
def test_force_rises_with_the_drop_and_with_the_hand_that_spreads_it(kappa, drop, beta):
    cap = read_table().at(kappa)
    force, slope = cap.force(drop)
    s, by = cap.yields(drop)
    assert force > 0
    assert slope > 0
    assert slope * (1 + beta * s) > force * beta * by  # a gas under a rising drop pushes harder
    assert cap.flattening(drop)[1] >= -0.05  # the contact of the solver behind the table advances node by node
    assert 0 < cap.limit < 0.5


def test_past_its_ends_it_is_that_of_the_end():
    table = read_table()
    assert table.at(1e9).force(0.1) == table.at(256.0).force(0.1)
    assert table.at(1e-9).force(0.1) == table.at(0.25).force(0.1)
    with pytest.raises(InvalidInput, match="kappa"):
        table.at(0.0)
