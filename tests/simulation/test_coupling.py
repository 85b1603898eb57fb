import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.simulation.coupling import couple


def power(factor, exponent=1.5):
    return lambda d: (factor * d**exponent, exponent * factor * d ** (exponent - 1)) if d > 0 else (0.0, 0.0)


@given(exponent=st.floats(-6, 6), power_=st.floats(0.5, 3.0), other=st.floats(0.3, 3.0), travel=st.floats(1e-7, 0.03))
def test_any_two_power_laws_meet(exponent, power_, other, travel):
    membrane = power(1.0 / travel**power_, power_)
    thing = power(10**exponent / travel**other, other)
    found = couple(membrane, thing, travel)
    assert found.iterations <= 12
    assert thing(found.drop)[0] == pytest.approx(found.force, rel=1e-6)
