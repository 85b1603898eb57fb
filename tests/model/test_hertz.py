import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.model import hertz_depth, hertz_force

# (shape, size, object modulus, force): the paper's formulas written out with numbers, depth 10 mm, E* 6 kPa, v 0.5
PRINTED = [
    ("sphere", {"radius": 0.01}, math.inf, 4 / 3 * math.sqrt(0.01**3 * 0.01) / (0.75 / 6e3)),
    ("sphere", {"radius": 0.01}, 50e3, 4 / 3 * math.sqrt(0.01**3 * 0.01) / (0.75 / 6e3 + 0.75 / 50e3)),
    ("cylinder", {"radius": 0.01}, math.inf, 2 * 0.01 * 0.01 * 6e3),
    ("cone", {"angle": math.pi / 4}, math.inf, 2 * 0.01**2 * 6e3 / (math.pi * 0.75)),
]
SIZES = {"sphere": "radius", "cylinder": "radius", "cone": "angle"}


@pytest.mark.parametrize(("shape", "size", "object_modulus", "expected"), PRINTED)
def test_force_is_the_printed_formula(shape, size, object_modulus, expected):
    assert hertz_force(shape, 0.01, 6e3, object_modulus=object_modulus, **size) == pytest.approx(expected, rel=1e-14)


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


def test_no_depth_gives_no_force():
    for shape, size in SIZES.items():
        assert hertz_force(shape, 0.0, 5e3, **{size: 0.5}) == 0.0


@pytest.mark.parametrize(
    ("shape", "depth", "modulus", "kwargs", "said"),
    [
        ("cube", 0.01, 6e3, {"radius": 0.01}, "sphere, cylinder, cone"),
        ("sphere", -0.01, 6e3, {"radius": 0.01}, "depth must be at least 0 m"),
        ("sphere", math.nan, 6e3, {"radius": 0.01}, "depth must be finite"),
        ("sphere", "deep", 6e3, {"radius": 0.01}, "depth must be a number"),
        ("sphere", 0.01, 0.0, {"radius": 0.01}, "modulus must be above 0 Pa"),
        ("sphere", 0.01, 6e3, {}, "a sphere needs radius"),
        ("sphere", 0.01, 6e3, {"radius": 0.0}, "radius must be above 0 m"),
        ("sphere", 0.01, 6e3, {"radius": -0.01}, "radius must be above 0 m"),
        ("sphere", 0.01, 6e3, {"radius": math.inf}, "radius must be finite"),
        ("sphere", 0.01, 6e3, {"radius": 0.01, "angle": 0.5}, "no angle"),
        ("sphere", 0.01, 6e3, {"radius": 0.01, "poisson": 0.6}, "poisson must lie"),
        ("sphere", 0.01, 6e3, {"radius": 0.01, "object_modulus": 0.0}, "object_modulus must be above 0 Pa"),
        ("cylinder", 0.01, 6e3, {"radius": 0.01, "object_modulus": 1e5}, "the cylinder is rigid"),
        ("cone", 0.01, 6e3, {"radius": 0.01}, "a cone needs angle"),
        ("cone", 0.01, 6e3, {"angle": math.pi / 2}, "between 0 and pi/2"),
        ("cone", 0.01, 6e3, {"angle": 0.0}, "angle must be above 0 rad"),
    ],
)
def test_bad_input_says_what_was_expected(shape, depth, modulus, kwargs, said):
    with pytest.raises(InvalidInput, match=said):
        hertz_force(shape, depth, modulus, **kwargs)


def test_a_negative_force_has_no_depth():
    with pytest.raises(InvalidInput, match="force must be at least 0 N"):
        hertz_depth("sphere", -1.0, 6e3, radius=0.01)
