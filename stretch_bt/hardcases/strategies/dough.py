"""Doughs from slack to stone, ways in pieces, and bonds of tack."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from stretch_bt.simulation.dough.material import Dough

__all__ = ["BONDS", "CUTS", "DOUGHS", "HEADINGS"]

#: yields from 1 Pa to 1 GPa, springback from none to a thousand times that, with and without thickening
DOUGHS = st.builds(
    lambda stress, ratio, thickening: Dough(10**stress, ratio * 10**stress, thickening),
    st.floats(0, 9),
    st.floats(1, 1e3),
    st.sampled_from([0.0, 1.0, 1e6]),
)
#: where a way is cut, as parts of it, and the way's direction, rad
CUTS, HEADINGS = st.lists(st.floats(0.01, 0.99), min_size=1, max_size=12), st.floats(-math.pi, math.pi)
#: pull, weight and hold of a bond, N
BONDS = st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
