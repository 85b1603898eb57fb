"""Presses of the membrane, closed shapes, and stretches of its material."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

__all__ = ["DEPTHS", "PRINCIPAL", "presses"]

#: depth of a press in closed form, m
DEPTHS = st.floats(1e-6, 0.012)
#: principal stretches of rubber, from creased to two and a half times as long
PRINCIPAL = st.floats(0.75, 2.5)

_INDENTERS = st.one_of(
    st.floats(4, 40).map(lambda d: f"sphere:{d}mm"),
    st.floats(6, 40).map(lambda d: f"cylinder:{d}mm"),
    st.floats(20, 70).map(lambda a: f"cone:{a}deg"),
    st.floats(6, 40).map(lambda a: f"cube:{a}mm"),
)


@st.composite
def presses(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the options of a press: any indenter, from slack to 80 mm, from a graze to 20 mm, anywhere, leaning."""
    place, lean = st.floats(-0.06, 0.06), st.floats(-0.2, 0.2)
    return {
        "indenter": draw(_INDENTERS),
        "stretch": draw(st.one_of(st.just(0.0), st.floats(0.0, 0.08))),
        "depth": draw(st.one_of(st.floats(1e-6, 1e-3), st.floats(1e-3, 0.02))),
        "at": (draw(place), draw(place)),
        "tilt": draw(st.one_of(st.just((0.0, 0.0)), st.tuples(lean, lean))),
    }
