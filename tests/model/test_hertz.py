import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.model import hertz_depth, hertz_force

SIZES = {"sphere": "radius", "cylinder": "radius", "cone": "angle"}


@given(
    shape=st.sampled_from(sorted(SIZES)),
    depth=st.floats(0, 0.1),
    modulus=st.floats(1, 1e9),
    size=st.floats(1e-4, 1.5),
    poisson=st.floats(-0.9, 0.5),
)
def test_depth_is_the_exact_inverse(shape, depth, modulus, size, poisson):
    kwargs = {SIZES[shape]: size, "poisson": poisson}
    force = hertz_force(shape, depth, modulus, **kwargs)
    assert hertz_depth(shape, force, modulus, **kwargs) == pytest.approx(depth, rel=1e-12, abs=1e-100)
    assert isinstance(force, float)


@given(depths=st.lists(st.floats(0, 0.05), min_size=1, max_size=5), compliance=st.floats(1e3, 1e7))
def test_arrays_come_back_as_arrays(depths, compliance):
    forces = hertz_force("sphere", np.array(depths), 5e3, radius=0.02, object_modulus=compliance)
    assert forces.shape == (len(depths),)
    back = hertz_depth("sphere", forces, 5e3, radius=0.02, object_modulus=compliance)
    np.testing.assert_allclose(back, depths, rtol=1e-12, atol=1e-100)
