"""The law of a soft object: force and deflection are inverse, and derivatives agree with differences of the values."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.model import COMPLIANCES, POWERS, STIFFENINGS
from stretch_bt.model.palpation.law import MM, ObjectLaw

LAWS = {"compliance": COMPLIANCES, "power": POWERS, "stiffening": STIFFENINGS}


@settings(max_examples=60, deadline=None)
@given(**LAWS, share=st.floats(1e-3, 6.0))
def test_the_force_at_the_deflection_under_a_force_is_that_force(compliance, power, stiffening, share):
    law = ObjectLaw(compliance, power, stiffening)
    found, exponent, _ = law.deflection(np.log([share]))
    assert law.log_force(float(found[0]))[0] == pytest.approx(np.log(share), abs=1e-9)
    assert exponent[0] == pytest.approx(power + stiffening * found[0] / MM)


@settings(max_examples=60, deadline=None)
@given(**LAWS, share=st.floats(1e-2, 4.0))
def test_derivatives_are_those_of_the_values(compliance, power, stiffening, share):
    law = np.array([compliance, power, stiffening])
    _, _, rows = ObjectLaw(*law).deflection(np.log([share]))
    drop = 2e-3
    _, row = ObjectLaw(*law).log_force(drop)
    for k, step in enumerate((1e-9, 1e-6, 1e-6)):
        moved = step * np.eye(3)[k]
        more, less = ObjectLaw(*law + moved), ObjectLaw(*law - moved)
        by_force = more.deflection(np.log([share]))[0] - less.deflection(np.log([share]))[0]
        assert rows[0, k] == pytest.approx(by_force[0] / (2 * step), rel=1e-4, abs=1e-8)
        by_drop = more.log_force(drop)[0] - less.log_force(drop)[0]
        assert row[k] == pytest.approx(by_drop / (2 * step), rel=1e-4, abs=1e-8)
