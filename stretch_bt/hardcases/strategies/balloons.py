"""Caps, fills, curves, and the paths that a hand may lead them on."""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["DROPS", "HANDS", "PATHS", "SOFTNESS", "STEPS", "TIMES"]

#: drops of a top, m, in hundredths of a millimetre, so that some come again
DROPS = st.integers(0, 2500).map(lambda k: k * 1e-5)
#: times between two drops, s: none, a tick, and for ever
TIMES = st.sampled_from([0.0, 1e-3, 0.01, 0.05, 1.0, 3.0, 1e6])
#: drops with the time to each
PATHS = st.lists(st.tuples(DROPS, TIMES), max_size=6)
#: modulus of the hand times radius over pressure, and softness of a gas
HANDS, SOFTNESS = st.floats(0.7, 300.0), st.floats(0.0, 0.2)
#: factors from each point of a curve to the next, to the right and upwards
STEPS = st.lists(st.tuples(st.floats(1.05, 3.0), st.floats(1.0, 8.0)), min_size=2, max_size=10)
