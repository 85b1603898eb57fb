import pytest
from hypothesis import given

from stretch_bt.hardcases.strategies.coupling import RATIOS, TRAVELS, membrane_powers, object_powers
from stretch_bt.simulation.coupling import couple


def power(factor, exponent=1.5):
    return lambda d: (factor * d**exponent, exponent * factor * d ** (exponent - 1)) if d > 0 else (0.0, 0.0)


@given(exponent=RATIOS, power_=membrane_powers(), other=object_powers(), travel=TRAVELS)
def test_any_two_power_laws_meet(exponent, power_, other, travel):
    membrane = power(1.0 / travel**power_, power_)
    thing = power(10**exponent / travel**other, other)
    found = couple(membrane, thing, travel)
    assert found.iterations <= 12
    assert thing(found.drop)[0] == pytest.approx(found.force, rel=1e-6)
