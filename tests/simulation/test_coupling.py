import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.errors import InvalidInput, NoEquilibrium
from stretch_bt.simulation.coupling import couple
from stretch_bt.simulation.objects.buckling import BucklingResponse
from stretch_bt.simulation.objects.response import LinearResponse
from stretch_bt.simulation.solve import find_root

TRAVEL = 0.012


def power(factor, exponent=1.5):
    return lambda d: (factor * d**exponent, exponent * factor * d ** (exponent - 1)) if d > 0 else (0.0, 0.0)


def plastic(stiffness, yield_force, hardening):
    limit = yield_force / stiffness
    return lambda u: (stiffness * u, stiffness) if u < limit else (yield_force + hardening * (u - limit), hardening)


def viscous(stiffness, drag, start):
    """One implicit step of a spring and, from `start` on, a dashpot beside it."""
    return lambda u: (stiffness * u + drag * max(u - start, 0.0), stiffness + drag * (u > start))


def buckling(stiffness, limit, after):
    """Falls from its limit to half of it over as much drop again, and rises from there."""
    top = limit / stiffness

    def law(u):
        if u < top:
            return stiffness * u, stiffness
        if u < 2 * top:
            return limit * (1.5 - u / (2 * top)), -limit / (2 * top)
        return limit / 2 + after * (u - 2 * top), after

    return law, (top, 2 * top)


def objects(stiffness):
    """Return object laws of about this stiffness, with the drops at which they have a kink."""
    force = stiffness * TRAVEL
    return {
        "elastic": (power(stiffness, 1.0), ()),
        "stiffening": (power(stiffness / TRAVEL**0.6, 1.6), ()),
        "softening": (power(stiffness * TRAVEL**0.5, 0.5), ()),
        "plastic": (plastic(stiffness, 0.1 * force, 0.0), (0.1 * TRAVEL,)),
        "hardening": (plastic(stiffness, 0.1 * force, 1e-3 * stiffness), (0.1 * TRAVEL,)),
        "viscous": (viscous(0.1 * stiffness, 20 * stiffness, 0.2 * TRAVEL), (0.2 * TRAVEL,)),
        "buckling": buckling(stiffness, 0.2 * force, 0.4 * stiffness),
    }


def bisected(membrane, thing, low, high):
    """Return the drop at which the forces agree, to the last bit, on a bracket in which they agree once."""
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if membrane(TRAVEL - middle)[0] > thing(middle)[0] else (low, middle)
    return (low + high) / 2


@pytest.mark.parametrize("kind", objects(1.0))
@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
def test_series_equilibrium_at_every_stiffness_ratio(kind, exponent):
    """Object over membrane stiffness from 1e-3 to 1e3: at most 10 evaluations, and the force of the bracketed reference."""
    membrane = power(1.0 / TRAVEL**exponent, exponent)
    for k in range(25):
        thing, kinks = objects(10 ** (-3 + k / 4) / TRAVEL)[kind]
        found = couple(membrane, thing, TRAVEL, kinks=kinks)
        first = next(k for k in (*kinks, TRAVEL) if k >= found.drop * (1 - 1e-12))
        before = max((k for k in kinks if k < first), default=0.0)
        force = membrane(TRAVEL - bisected(membrane, thing, before, min(first, TRAVEL)))[0]
        assert found.force == pytest.approx(force, rel=1e-6)
        assert found.depth + found.drop == pytest.approx(TRAVEL, rel=1e-9)
        assert found.iterations <= 10


@given(exponent=st.floats(-6, 6), power_=st.floats(0.5, 3.0), other=st.floats(0.3, 3.0), travel=st.floats(1e-7, 0.03))
def test_any_two_power_laws_meet(exponent, power_, other, travel):
    membrane = power(1.0 / travel**power_, power_)
    thing = power(10**exponent / travel**other, other)
    found = couple(membrane, thing, travel)
    assert found.iterations <= 12
    assert thing(found.drop)[0] == pytest.approx(found.force, rel=1e-6)


def test_the_first_equilibrium_on_the_way_is_reached_and_a_jump_is_told():
    """A soft membrane drives the object through its limit point; coming back, it stays where it has gone."""
    law, kinks = buckling(1000.0, 1.0, 1000.0)
    membrane = power(200.0, 1.0)
    below = couple(membrane, law, 0.0058, kinks=kinks)
    assert not below.jumped
    assert below.drop < kinks[0]
    past = couple(membrane, law, 0.0061, kinks=kinks, start=below.drop)
    assert past.jumped
    assert past.drop > kinks[1]
    back = couple(membrane, law, 0.0058, kinks=kinks, start=past.drop)
    assert not back.jumped
    assert back.drop > kinks[1]


def test_an_equilibrium_within_a_falling_piece_is_not_passed():
    """At neither end of the fall the object holds, but on the way it does: scanned in small steps, the first one is found."""
    membrane, travel = power(1471.0), 6.785e-3
    object_ = BucklingResponse(430.0, 0.584, 0.4, 0.890, 3.905e-3)
    law = object_.law(object_.start(), 0.0)
    found = couple(membrane, law, travel, kinks=object_.kinks(object_.start()))
    drops = [travel * k / 20000 for k in range(1, 20000)]
    first = next(d for d in drops if membrane(travel - d)[0] <= law(d)[0])
    assert found.drop == pytest.approx(first, abs=travel / 10000)


def test_two_springs_in_series_and_what_stays_down():
    spring = power(300.0, 1.0)
    assert couple(spring, LinearResponse(900.0).law(None, 0.0), TRAVEL).force == pytest.approx(
        TRAVEL / (1 / 300 + 1 / 900)
    )
    dented = couple(spring, lambda u: (900 * max(u - 0.004, 0.0), 900.0), TRAVEL, rest=0.004)
    assert dented.force == pytest.approx((TRAVEL - 0.004) / (1 / 300 + 1 / 900))
    assert couple(spring, spring, 0.003, rest=0.004) == (0.0, 0.003, 0.0, 0, False)


def test_a_jump_of_the_force_is_met_where_it_is():
    found = couple(power(100.0, 1.0), lambda u: (0.0, 0.0) if u < 0.005 else (5.0, 1.0), TRAVEL)
    assert found.drop == pytest.approx(0.005)


@pytest.mark.parametrize(("rest", "travel"), [(0.0, -0.01), (0.0, math.nan), (-1.0, 0.01), (math.inf, 0.01)])
def test_bad_input(rest, travel):
    with pytest.raises(InvalidInput, match="at least 0 m"):
        couple(power(1e3), power(1e3), travel, rest=rest)


def test_what_does_not_converge_is_said():
    with pytest.raises(NoEquilibrium, match="a case: no convergence"):
        find_root(lambda x: (math.nan, math.nan), 0.0, 1.0, 0.5, "a case")


def test_newton_is_kept_in_the_bracket():
    assert find_root(
        lambda x: (math.atan(0.3 - x), -1 / (1 + (0.3 - x) ** 2)), -100.0, 90.0, 90.0, ""
    ).x == pytest.approx(0.3)


@pytest.mark.parametrize("low_force", [0.0, 0.3])
def test_a_solver_whose_force_jumps_where_forces_agree_is_met_there(low_force):
    def thing(drop):
        return low_force + 300.0 * drop, 300.0

    smooth = couple(power(100.0, 1.2), thing, TRAVEL)

    def rough(depth):
        force, slope = power(100.0, 1.2)(depth)
        return force * (1 + math.copysign(1e-3, depth - smooth.depth)), slope

    found = couple(rough, thing, TRAVEL, kinks=(1e-9,), close=1e-5)
    assert found.drop == pytest.approx(smooth.drop, abs=1e-5 * TRAVEL)
    assert found.iterations < 30


def test_what_holds_harder_than_it_is_pressed_stays_as_it_is():
    found = couple(power(100.0), lambda drop: (5.0 + 300.0 * drop, 300.0), TRAVEL, kinks=(1e-9,), rest=1e-3)
    assert found.drop == pytest.approx(1e-3)
    assert found.force == pytest.approx(power(100.0)(TRAVEL - 1e-3)[0])
