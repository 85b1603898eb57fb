"""Images, masks, rims and outlines as perception meets them."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from stretch_bt.perception.size.conformal import Rim

__all__ = ["ANGLES", "IMAGES", "MASKS", "RATIOS", "RIMS", "RULES", "SIDES"]

#: images (h, w) float32, m, with holes, steps and little else
IMAGES = arrays.arrays(
    np.float32,
    st.tuples(st.integers(0, 14), st.integers(0, 14)),
    elements=st.sampled_from([0.0, 0.18, 0.19, 0.2, 0.2, 0.2, 0.201]),
)
RULES = st.sampled_from(["mean", "either"])
#: two masks (h, w) of one shape
MASKS = st.tuples(st.integers(1, 12), st.integers(1, 12)).flatmap(
    lambda shape: st.tuples(arrays.arrays(np.bool_, shape), arrays.arrays(np.bool_, shape))
)
#: sides of a rectangle, m, its turn, rad, and the logarithm of the ratio of the tensions
SIDES, ANGLES, RATIOS = st.floats(8e-3, 32e-3), st.floats(-3.0, 3.0), st.floats(0.0, 3.5)
#: elliptic rims of contacts
RIMS = st.builds(
    Rim,
    st.floats(-8e-3, 8e-3),
    st.floats(-8e-3, 8e-3),
    st.floats(4e-3, 16e-3),
    st.floats(4e-3, 16e-3),
    st.floats(-0.5, 3.5),
)
