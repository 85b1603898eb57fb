"""Places that force models know, objects that palpation meets, and tables of presses."""

from __future__ import annotations

from hypothesis import strategies as st

from stretch_bt.model.calibration.characterization import PressRow
from stretch_bt.model.calibration.sensitivity import METHODS, Found, Sensed

__all__ = [
    "COMPLIANCES",
    "HERTZ_DEPTHS",
    "HERTZ_RADII",
    "MEMBRANE_DEPTHS",
    "MEMBRANE_RADII",
    "POWERS",
    "PRESSES",
    "PROVENANCES",
    "SENSED",
    "STIFFENINGS",
    "STRETCHES",
]

#: stretch of a hand, m
STRETCHES = st.floats(0.0, 0.08)
#: radius and depth, m, within the calibration of the paper, and within the table of the membrane
HERTZ_RADII, HERTZ_DEPTHS = st.floats(0.0025, 0.040), st.floats(1e-4, 0.030)
MEMBRANE_RADII, MEMBRANE_DEPTHS = st.floats(0.005, 0.045), st.floats(1e-4, 0.015)
#: the law of an object: compliance, m, its power, and how that grows a mm
COMPLIANCES, POWERS, STIFFENINGS = st.floats(1e-4, 6e-3), st.floats(0.6, 3.0), st.floats(-0.02, 0.4)

_LENGTHS, _NUMBERS = st.floats(0.0, 0.3), st.floats(-1e3, 1e3)
#: rows of a characterisation
PRESSES = st.builds(
    PressRow,
    st.sampled_from(["sphere", "cylinder", "cone"]),
    st.floats(0.001, 1.5),
    _LENGTHS,
    st.floats(-0.005, 0.03),
    st.integers(1, 50),
    _NUMBERS,
    st.floats(0.0, 10.0),
    _LENGTHS,
    st.floats(0.0, 1e6),
)
PROVENANCES = st.dictionaries(st.text(), st.none() | st.booleans() | st.integers() | st.text(), max_size=4)
_WIDTHS = st.floats(1e-4, 0.2)
_REASONS = st.sampled_from(["", "no contact, nothing", 'it is "round", not flat', "one\nline\r\nor two"])


@st.composite
def _found_by(draw: st.DrawFn, method: str) -> Found:
    reason = draw(_REASONS)
    if reason:
        return Found(method, refused=" ".join(reason.split()))
    i, i_sd, j, j_sd = (draw(_WIDTHS) for _ in range(4))
    return Found(method, i, i_sd, j, j_sd, draw(st.sampled_from(["", "circle"])))


#: presses of a map of sensitivity
SENSED = st.builds(
    Sensed,
    st.just("cylinder"),
    st.floats(5e-3, 8e-2),
    STRETCHES,
    st.floats(-1e-3, 0.03),
    st.integers(1, 9),
    st.tuples(*(_found_by(method) for method in METHODS)),
    st.floats(0, 1e5),
)
