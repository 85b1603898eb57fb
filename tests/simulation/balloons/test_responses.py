import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardcases.domains.balloons.responses import BODY, RESPONSES, after
from stretch_bt.hardcases.strategies.balloons import DROPS, PATHS, TIMES
from stretch_bt.simulation.coupling import couple


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
