"""Points that shapes are fitted to."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

__all__ = ["POINTS"]

#: (n, 3), m: none to thirty, far apart or in one place
POINTS = arrays.arrays(np.float64, st.tuples(st.integers(0, 30), st.just(3)), elements=st.floats(-1e3, 1e3))
