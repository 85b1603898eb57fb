"""The force of a lump by how far it is pressed: implicit, rising, and never past what it flows at."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.dough import DOUGHS
from stretch_bt.simulation.dough.lump import cube
from stretch_bt.simulation.dough.material import Dough
from stretch_bt.simulation.dough.resistance import Resistance

EDGE = 0.025


@settings(max_examples=30, deadline=None)
@given(
    dough=DOUGHS,
    travel=st.floats(0, 0.3),
    step=st.floats(-3, 3),
)
def test_the_force_rises_with_the_drop(dough, travel, step):
    lump, _ = cube(EDGE).rolled((travel, 0.0), 1.0, Dough(5e3, 1e5))
    felt = Resistance(lump, dough, 0.19)
    forces = np.array([felt.force(drop, 10**step)[0] for drop in np.linspace(0, 1.2 * lump.height, 200)])
    assert np.isfinite(forces).all()
    assert (np.diff(forces) >= -1e-9 * forces[-1]).all()
    assert forces[0] <= 1e-6
