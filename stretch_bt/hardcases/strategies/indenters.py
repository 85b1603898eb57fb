"""Shapes of any size and proportion."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from stretch_bt.simulation.membrane.indenters.base import Indenter
from stretch_bt.simulation.membrane.indenters.box import Box
from stretch_bt.simulation.membrane.indenters.cone import Cone
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.membrane.indenters.half_cylinder import HalfCylinder
from stretch_bt.simulation.membrane.indenters.ring import Ring
from stretch_bt.simulation.membrane.indenters.sphere import Sphere
from stretch_bt.simulation.membrane.indenters.turned import Turned
from stretch_bt.simulation.membrane.indenters.wire import Wire
from stretch_bt.simulation.membrane.indenters.wire_polygon import WirePolygon

__all__ = ["SHAPES"]

_WIDE, _TURN = st.floats(5e-3, 50e-3), st.floats(-math.pi, math.pi)

#: a shape of each kind, some of them turned
SHAPES: st.SearchStrategy[Indenter] = st.one_of(
    st.builds(Sphere, st.floats(1e-3, 0.1)),
    st.builds(Cylinder, _WIDE, st.floats(1e-4, 2e-3)),
    st.builds(Cone, st.floats(0.1, 1.4), st.floats(1e-4, 2e-3)),
    st.builds(Box, _WIDE, _WIDE, _TURN),
    st.builds(Wire, st.floats(0.5e-3, 4e-3), _WIDE, _TURN),
    st.builds(HalfCylinder, _WIDE, _WIDE),
    st.builds(Ring, st.floats(0.5e-3, 2e-3), _WIDE),
    st.builds(WirePolygon, st.floats(0.5e-3, 1.5e-3), st.floats(20e-3, 50e-3), st.integers(3, 6)),
    st.builds(Turned, st.builds(Box, _WIDE, _WIDE), _TURN),
)
