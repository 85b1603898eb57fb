"""Dough that sticks to the hand: what it does to a hand that rises, and when it comes along."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardcases.domains.dough.runs import STICKY, stuck
from stretch_bt.hardcases.strategies.dough import BONDS
from stretch_bt.simulation.advisor.advise import advise
from stretch_bt.simulation.hanging import Grip, between, pulled_by
from stretch_bt.simulation.membrane.indenters.cylinder import Cylinder
from stretch_bt.simulation.scene import parse_scene


def test_a_sketch_shows_it_in_the_air():
    world, _, truth = stuck("tack: {pull: 0.5 N}", 0.06, (0.0, 0.024), (0.0, 0.040))
    assert np.array(world.sketch(world.latest)["side"])[:, 1].max() == pytest.approx(truth["height"], abs=5e-4)


@pytest.mark.parametrize(
    ("effects", "on", "least", "why"),
    [
        ("", False, 0.0, "pull over force"),
        ("tack: {pull: 0.5 N}", True, 0.03, "comes along: pull 0.5 N, held by 0.29 N"),
        ("tack: {pull: 0.5 N, hold: 0.4 N}", True, 0.0, "pull over force"),
    ],
)
def test_the_advisor_says_that_it_comes_along(effects, on, least, why):
    (verdict,) = [v for v in advise(parse_scene(f"{STICKY}effects: {{{effects}}}\n")) if v.name == "tack"]
    assert verdict.on == on
    assert why in verdict.why
    assert verdict.estimate >= least


def test_only_the_sheet_can_be_pulled_down():
    scene = parse_scene(f"{STICKY}fidelity: hertz\neffects: auto\n")
    (verdict,) = [v for v in advise(scene) if v.name == "tack"]
    assert not verdict.on
    assert "hertz fidelity" in verdict.why


def spring(way):
    return 100.0 * way, 100.0


@given(
    bond=BONDS,
    above=st.floats(0.0, 1.0),
    raised=st.sampled_from([0.0, 0.01]),
)
def test_no_bond_bears_more_than_it_can(bond, above, raised):
    pull, weight, hold = bond
    grip = Grip(pull, weight, hold, Cylinder(0.015), raised if pull > weight + hold else 0.0)
    found = pulled_by(spring, grip, above)
    if found is None:
        assert not grip.lifts
        assert 100.0 * above >= min(pull, weight + hold) - 1e-9
        return
    assert found.force <= min(pull, weight + hold) + 1e-6
    assert found.force == pytest.approx(100.0 * found.down, abs=1e-6)
    assert found.down + found.raised == pytest.approx(above)
    assert 0 <= found.raised <= above
    assert not found.raised or (grip.lifts and found.force == weight)


@pytest.mark.parametrize("stretch", [0.0, 0.004, 0.01, 0.0799999999, 0.08])
def test_a_law_between_stretches_is_a_straight_line(stretch):
    law = between(stretch, lambda known: lambda way: (known * way, known))
    assert law(2.0) == pytest.approx((2 * stretch, stretch))
