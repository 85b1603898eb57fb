import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardcases.strategies.balloons import DROPS, PATHS, TIMES
from stretch_bt.simulation.balloons.compacting import Compacting
from stretch_bt.simulation.balloons.elastic import Elastic
from stretch_bt.simulation.balloons.laws import hertz, together
from stretch_bt.simulation.balloons.lessened import Lessened
from stretch_bt.simulation.balloons.relaxing import Relaxing
from stretch_bt.simulation.balloons.softened import Softened
from stretch_bt.simulation.coupling import couple

RADIUS, TIME = 0.03, 2.0
SKIN, GEL = hertz(50e3, RADIUS), hertz(20e3, RADIUS)
BODY = Elastic(together(SKIN, GEL))
RESPONSES = {
    "elastic": BODY,
    "lessened": Lessened(BODY, hertz(5e3, RADIUS)),
    "softened": Softened(BODY, SKIN, 0.2),
    "compacting": Compacting(BODY, 3.0),
    "relaxing": Relaxing(BODY, GEL, TIME),
    "relaxing and softened": Relaxing(Softened(BODY, SKIN, 0.2), GEL, TIME),
    "relaxing and compacting": Relaxing(Compacting(BODY, 3.0), GEL, TIME),
}


def after(response, path, state=None):
    state = response.start() if state is None else state
    for drop, dt in path:
        state = response.after(state, drop, dt)
    return state


@pytest.mark.parametrize("name", RESPONSES)
@given(path=PATHS, drop=DROPS, dt=TIMES)
def test_after_any_path_the_law_is_monotone_and_tells_its_slope(name, path, drop, dt):
    """From the rest on it only rises; up to there it is 0."""
    response = RESPONSES[name]
    state = after(response, path)
    law, rest, kinks = response.law(state, dt), response.rest(state, dt), response.kinks(state)
    force, slope = law(drop)
    assert force >= 0
    assert slope >= 0
    assert math.isfinite(force)
    assert law(0.0)[0] == law(-1e-3)[0] == 0.0
    assert law(rest)[0] == 0.0
    step = 1e-8
    if drop > rest + 1e-6 and all(abs(drop - k) > 2 * step for k in kinks):
        assert (law(drop + step)[0] - law(drop - step)[0]) / (2 * step) == pytest.approx(slope, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("name", RESPONSES)
@given(path=PATHS, exponent=st.floats(-3, 3), dt=TIMES)
def test_in_series_with_any_membrane_there_is_an_equilibrium(name, path, exponent, dt):
    response, travel = RESPONSES[name], 0.02
    state = after(response, [(min(d, travel / 2), t) for d, t in path])
    law, rest = response.law(state, dt), response.rest(state, dt)
    factor = 10**exponent * BODY.by_drop(travel)[0] / travel**1.5

    def membrane(depth):
        root = math.sqrt(max(depth, 0.0))
        return factor * root * max(depth, 0.0), 1.5 * factor * root

    found = couple(membrane, law, travel, rest=rest, kinks=response.kinks(state))
    assert found.drop + found.depth == pytest.approx(travel)
    assert rest <= found.drop * (1 + 1e-9)
    assert law(found.drop)[0] == pytest.approx(membrane(found.depth)[0], rel=1e-6)
