import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model.root import rising_root


@given(root=st.floats(-0.9, 0.9), power=st.sampled_from([1, 3, 5]), slope=st.floats(0.1, 1e3))
def test_it_finds_the_place(root, power, slope):
    found = rising_root(lambda x: slope * ((x - root) ** power + 1e-3 * (x - root)), -1.0, 1.0)
    assert found == pytest.approx(root, abs=1e-9)
