"""Laws of membranes and objects whose ratio of stiffness is anything."""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["FORCES", "RATIOS", "TRAVELS", "membrane_powers", "object_powers"]

#: logarithm of the object's stiffness over the membrane's, and the travel, m
RATIOS, TRAVELS = st.floats(-6, 6), st.floats(1e-7, 0.03)
#: force on walls and roofs, N
FORCES = st.floats(1e-6, 20)


def membrane_powers() -> st.SearchStrategy[float]:
    """Powers of a membrane's force in its depth."""
    return st.floats(0.5, 3.0)


def object_powers() -> st.SearchStrategy[float]:
    """Powers of an object's force in its drop."""
    return st.floats(0.3, 3.0)
