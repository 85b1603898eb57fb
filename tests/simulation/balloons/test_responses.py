import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput
from stretch_bt.simulation.balloons.compacting import Compacting
from stretch_bt.simulation.balloons.elastic import Elastic
from stretch_bt.simulation.balloons.laws import hertz, linear, no_force, scaled, together
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
drops = st.integers(0, 2500).map(lambda k: k * 1e-5)
paths = st.lists(st.tuples(drops, st.sampled_from([0.0, 1e-3, 0.05, 1.0, 1e6])), max_size=6)


def after(response, path, state=None):
    state = response.start() if state is None else state
    for drop, dt in path:
        state = response.after(state, drop, dt)
    return state


@pytest.mark.parametrize("name", RESPONSES)
@given(path=paths, drop=drops, dt=st.sampled_from([0.0, 0.01, 0.05, 3.0, 1e6]))
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
@given(path=paths, exponent=st.floats(-3, 3), dt=st.sampled_from([0.0, 0.05, 1e6]))
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


def test_a_held_gel_relaxes_as_the_closed_form_says():
    """F(t) = F_inf + F_sudden exp(-t / time) after a step, however the hold is divided."""
    response, drop = Relaxing(Elastic(SKIN), GEL, TIME), 2e-3
    for steps in (1, 7, 100):
        state = response.after(response.start(), drop, 0.0)
        for _ in range(steps):
            state = response.after(state, drop, 3.0 / steps)
        force = response.law(state, 0.0)(drop)[0]
        assert force == pytest.approx(SKIN(drop)[0] + GEL(drop)[0] * math.exp(-3.0 / TIME), rel=1e-10)


def test_fast_it_is_instantaneous_and_slow_it_is_relaxed():
    response, drop = Relaxing(Elastic(SKIN), GEL, TIME), 2e-3
    start = response.start()
    assert response.law(start, 0.0)(drop)[0] == pytest.approx(SKIN(drop)[0] + GEL(drop)[0])
    assert response.law(start, 1e6)(drop)[0] == pytest.approx(SKIN(drop)[0], rel=1e-5)


def test_the_error_of_a_ramp_falls_with_the_square_of_the_step():
    """Against the hereditary integral of an even press: q = int g'(s) exp(-(T - s) / time) ds."""
    from scipy.integrate import quad

    speed, end = 1e-3, 2.0
    right = quad(lambda s: GEL(speed * s)[1] * speed * math.exp((s - end) / TIME), 0, end, epsabs=1e-12)[0]
    response, errors = Relaxing(Elastic(no_force), GEL, TIME), []
    for steps in (20, 40, 80):
        path = [(speed * end * (k + 1) / steps, end / steps) for k in range(steps)]
        state = after(response, path)
        errors.append(abs(state.branch / right - 1))
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 3


def test_a_gel_that_was_held_down_comes_back():
    response = RESPONSES["relaxing"]
    held = after(response, [(3e-3, 0.0), (3e-3, 10.0)])
    rests = [response.rest(held, dt) for dt in (0.0, 0.1, 1.0, 10.0, 1e6)]
    assert 0 < rests[0] < 3e-3
    assert all(b < a for a, b in pairwise(rests))
    assert rests[-1] < 1e-6
    let_go = after(response, [(0.0, 0.05)] * 400, held)
    assert let_go.drop < 1e-4


def test_grains_keep_a_set_and_lose_the_work_that_the_ratio_says():
    response, deepest, count = RESPONSES["compacting"], 3e-3, 4000
    state = response.after(response.start(), deepest, 0.0)
    law = response.law(state, 0.0)
    loading, unloading = (
        sum(f(deepest * (k + 0.5) / count)[0] for k in range(count)) * deepest / count for f in (BODY.by_drop, law)
    )
    assert 1 - unloading / loading == pytest.approx(1 - 1 / 3, abs=1e-4)
    assert response.rest(state, 0.0) == pytest.approx(deepest * 2 / 3)
    just = deepest * (1 - 1e-9)
    assert law(just)[0] == pytest.approx(BODY.by_drop(deepest)[0], rel=1e-6)
    assert law(just)[1] == pytest.approx(3 * BODY.by_drop(deepest)[1], rel=1e-6)


@pytest.mark.parametrize("name", ["compacting", "softened"])
def test_ten_thousand_cycles_change_nothing_after_the_first(name):
    response = RESPONSES[name]
    first = after(response, [(3e-3, 0.01), (0.0, 0.01)])
    assert after(response, [(3e-3, 0.01), (0.0, 0.01), (2.9e-3, 0.01)] * 10_000, first) == first


def test_softened_rubber_is_softer_below_its_largest_drop_and_the_same_past_it():
    response = RESPONSES["softened"]
    law = response.law(response.after(response.start(), 3e-3, 0.0), 0.0)
    assert law(1e-3)[0] == pytest.approx(BODY.by_drop(1e-3)[0] - 0.2 * (2 / 3) * SKIN(1e-3)[0])
    assert law(3e-3) == BODY.by_drop(3e-3)
    assert law(4e-3) == BODY.by_drop(4e-3)


@pytest.mark.parametrize(
    ("name", "memory"),
    [
        ("elastic", None),
        ("lessened", None),
        ("softened", math.inf),
        ("compacting", math.inf),
        ("relaxing", 0.05),
        ("relaxing and softened", 0.05),
    ],
)
def test_each_says_what_it_remembers(name, memory):
    assert RESPONSES[name].memory == memory


@pytest.mark.parametrize("dt", [-1.0, math.nan, math.inf])
def test_a_step_of_time_is_a_time(dt):
    response = RESPONSES["relaxing"]
    with pytest.raises(InvalidInput, match="time step"):
        response.law(response.start(), dt)


def test_laws_add_and_scale():
    law = scaled(together(linear(2.0), linear(3.0)), 10.0, 0.5)
    assert law(0.25) == pytest.approx((25.0, 100.0))
    assert no_force(1.0) == (0.0, 0.0)
