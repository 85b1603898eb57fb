"""Loads between which a membrane is led."""

from __future__ import annotations

from hypothesis import strategies as st

from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.sheet.result import Load

__all__ = ["LOADS"]

_PLACE, _LEAN = st.floats(-0.05, 0.05), st.floats(-0.5, 0.5)

#: loads by one ball: stretch, depth, place, m, and tilt, rad
LOADS = st.builds(
    Load,
    st.just(Sphere(0.02)),
    st.floats(0.0, 0.08),
    st.floats(1e-6, 0.02),
    st.tuples(_PLACE, _PLACE),
    st.tuples(_LEAN, _LEAN),
)
