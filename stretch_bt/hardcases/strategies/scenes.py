"""Scene files whose objects have sizes in and out of their bounds."""

from __future__ import annotations

from hypothesis import strategies as st

__all__ = ["TEXTS"]

_SIZE = st.one_of(
    st.floats(-10, 300).map(lambda mm: f"{mm:.3g} mm"), st.sampled_from(["0 mm", "40 mm", "1 m", "5", "2 N"])
)
_LAW = st.one_of(st.just("rigid: true"), st.floats(-1, 1e5).map(lambda k: f"stiffness: {k:.3g} N/mm"))
_WORDS = st.sampled_from(["auto", "none", "all", "{sag: on}", "{white_noise: {sd: 50 mm}}", "{plasticity: on}"])
_FIDELITIES = st.sampled_from(["hertz", "axisymmetric", "sheet", "auto"])


def _scene(thing: str, effects: str, fidelity: str) -> str:
    return f"format: stretch-scene/1\nobject: {{{thing}}}\neffects: {effects}\nfidelity: {fidelity}\n"


_THINGS = st.one_of(
    st.builds("type: sphere, diameter: {}, {}".format, _SIZE, _LAW),
    st.builds("type: cylinder, diameter: {}, height: {}, {}".format, _SIZE, _SIZE, _LAW),
    st.builds("type: box, length: {}, width: {}, height: {}, {}".format, _SIZE, _SIZE, _SIZE, _LAW),
    st.builds("type: paper_box, length: {}, width: {}, height: {}".format, _SIZE, _SIZE, _SIZE),
    st.builds("type: wire_circle, diameter: {}".format, _SIZE),
    st.builds("type: dough, edge: {}, yield_stress: {:.3g} kPa".format, _SIZE, st.floats(0, 1e3)),
    st.builds(
        "type: balloon, diameter: {}, pressure: {:.3g} kPa, fill: {{type: {}}}".format,
        _SIZE,
        st.floats(-1, 12),
        st.sampled_from(["air", "water", "pudding", "seeds"]),
    ),
)
#: texts of scenes
TEXTS = st.builds(_scene, _THINGS, _WORDS, _FIDELITIES)
