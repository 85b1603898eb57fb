import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model import hertz_force, object_modulus
from stretch_bt.units import Estimate


@given(
    modulus=st.floats(1e3, 1e7), membrane=st.floats(1e3, 1e5), radius=st.floats(0.005, 0.05), both=st.floats(1e-3, 0.02)
)
def test_it_inverts_the_papers_formula(modulus, membrane, radius, both):
    force = hertz_force("sphere", both, membrane, radius=radius, object_modulus=modulus)
    depth = (force * 0.75 / (4 / 3 * membrane * math.sqrt(radius))) ** (2 / 3)
    found = object_modulus(*(Estimate(v, 0.0) for v in (force, both - depth, depth, radius)))
    assert found.value == pytest.approx(modulus, rel=1e-6)
    assert found.sd == 0.0
