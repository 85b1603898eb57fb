import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.root import rising_root


@given(root=st.floats(-0.9, 0.9), power=st.sampled_from([1, 3, 5]), slope=st.floats(0.1, 1e3))
def test_it_finds_the_place(root, power, slope):
    found = rising_root(lambda x: slope * ((x - root) ** power + 1e-3 * (x - root)), -1.0, 1.0)
    assert found == pytest.approx(root, abs=1e-9)


def test_outside_it_gives_the_nearer_end():
    assert rising_root(lambda x: x + 2, 0.0, 1.0) == 0.0
    assert rising_root(lambda x: x - 2, 0.0, 1.0) == 1.0


def test_a_jump_is_found_too():
    assert rising_root(lambda x: math.copysign(1.0, x - 0.3), 0.0, 1.0) == pytest.approx(0.3, abs=1e-9)
