"""Depth images near and far, with holes and edges, and effects of any strength."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from stretch_bt.simulation.effects import CameraEffect, registry

__all__ = ["DEPTHS", "effects"]

#: images (h, w) float32, m: nothing, at the lens, usual, and past the largest count
DEPTHS = arrays.arrays(
    np.float32,
    st.tuples(st.integers(0, 24), st.integers(0, 24)),
    elements=st.sampled_from([0.0, 1e-4, 0.004, 0.19, 0.2, 0.2, 0.2, 0.25, 9.0]),
)
_STRENGTHS: dict[str, st.SearchStrategy[Any]] = {
    "sd": st.floats(0, 50).map(lambda mm: f"{mm} mm"),
    "share": st.floats(0, 1),
    "rate": st.floats(0, 1).map(lambda mm: f"{mm} mm/s"),
    "kernel": st.floats(0, 8),
    "memory": st.floats(0, 0.99),
}


@st.composite
def effects(draw: st.DrawFn) -> Any:
    """Draw an effect of the camera with some of its parameters."""
    known = {name: effect for name, effect in registry().items() if issubclass(effect, CameraEffect)}
    effect = known[draw(st.sampled_from(sorted(known)))]
    fields = [name for name in _STRENGTHS if name in effect.Parameters.model_fields]
    chosen = {name: draw(_STRENGTHS[name]) for name in fields}
    return effect(effect.Parameters.model_validate(chosen))
